// Runs whose ranks die: wherever that is, the survivors finish them with the bits of an undisturbed run, or report that
// they cannot. Disasters of all kinds are drawn from seeds: see soak/disasters.h.
#include <string>
#include <vector>

#include "lab/soak/disasters.h"
#include "lab/soak/player.h"
#include "support/check.h"

namespace motes::test_recovery {
using soak::Disaster;
using soak::Played;
using Death = comm::Simulation::Death;

namespace {

soak::Way way_of(int ranks, const roles::Cast& cast) {
  soak::Way way;
  way.ranks = ranks;
  way.cast = cast;
  way.balancer = 1;
  return way;
}

soak::Story story() {
  soak::Story story;
  story.reads = story.pictures = story.streaks = true;
  return story;
}

Played played(const soak::Way& way, const std::vector<Death>& deaths, soak::Film& film, std::uint64_t order = 1) {
  soak::Accidents accidents;
  accidents.order = order;
  accidents.deaths = deaths;
  return play(story(), way, accidents, film);
}

soak::Film undisturbed() {
  soak::Film film;
  play(story(), {}, {}, film);
  return film;
}

}  // namespace

TEST(no_disaster_breaks_a_promise) {
  int losses = 0, restarts = 0, told = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Disaster disaster = soak::disaster(seed);
    if (!disaster.broken.empty())
      check::fail(__FILE__, __LINE__, "seed " + std::to_string(seed) + ": " + disaster.broken);
    if (disaster.kind == Disaster::Kind::losses && disaster.survived > 0) ++losses;
    if (disaster.kind == Disaster::Kind::restarts && disaster.survived > 0) ++restarts;
    if (disaster.reported) ++told;
  }
  CHECK(losses > 15 && restarts > 7 && told < 12);
}

TEST(a_disaster_is_the_same_each_time) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Disaster first = soak::disaster(seed), second = soak::disaster(seed);
    CHECK(first.kind == second.kind && first.died == second.died && first.survived == second.survived);
    CHECK(first.reported == second.reported);
  }
}

TEST(each_role_may_be_lost_and_the_last_calculator) {
  const soak::Film model = undisturbed();
  for (const int ranks : {2, 3, 5}) {
    for (int rank = 0; rank < ranks; ++rank) {
      for (std::uint64_t point = 60; point < 260; point += 50) {
        soak::Film film;
        const Played run = played(way_of(ranks, roles::cast_auto(ranks)), {{rank, point}}, film);
        CHECK(run.broken.empty() && run.end.empty() && run.losses == 1);
        CHECK(film.particles == model.particles && film.pictures == model.pictures);
      }
    }
  }
}

TEST(all_but_one_may_be_lost_one_after_another) {
  const soak::Film model = undisturbed();
  soak::Film film;
  const Played run = played(way_of(5, roles::cast_shared(5)), {{0, 120}, {3, 220}, {1, 320}, {4, 420}}, film);
  CHECK(run.broken.empty() && run.end.empty() && run.losses == 4);
  CHECK(film.particles == model.particles && film.pictures == model.pictures);
}

TEST(neighbours_that_are_lost_together_end_the_run_with_a_sentence) {
  int ended = 0;
  for (std::uint64_t order = 0; order < 20; ++order) {
    soak::Film film;
    const Played run = played(way_of(5, roles::cast_auto(5)), {{2, 250}, {3, 250}}, film, order);
    CHECK(run.broken.empty());
    if (run.end.find("lost together with the next one") != std::string::npos) ++ended;
  }
  CHECK(ended > 3);
}

TEST(those_that_are_left_keep_their_roles) {
  using roles::Cast;
  const Cast paper = roles::cast_auto(5);
  CHECK((roles::cast_left(paper, {0, 1, 3, 4}) == Cast{1, 0, {2, 3}}));
  CHECK((roles::cast_left(paper, {1, 2, 3, 4}) == Cast{0, 0, {1, 2, 3}}));
  CHECK((roles::cast_left(paper, {0, 2, 3, 4}) == Cast{0, 0, {1, 2, 3}}));
  CHECK((roles::cast_left(paper, {2, 4}) == Cast{0, 0, {0, 1}}));
  CHECK((roles::cast_left(paper, {0, 1}) == Cast{1, 0, {0, 1}}));
  CHECK((roles::cast_left(roles::cast_shared(3), {1, 2}) == Cast{0, 0, {0, 1}}));
  CHECK((roles::cast_managing(4) == Cast{1, 0, {1, 2, 3}}));
  CHECK(roles::cast_managing(2) == roles::cast_auto(2));
}

TEST(behind_a_loss_there_are_new_replicas_at_once) {
  const soak::Film model = undisturbed();
  int survived = 0;
  for (std::uint64_t order = 0; order < 12; ++order) {
    soak::Film film;
    const Played run = played(way_of(5, roles::cast_auto(5)), {{2, 210}, {3, 275}}, film, order);
    CHECK(run.broken.empty() && run.end.empty());
    if (run.losses == 2) ++survived;
    CHECK(film.particles == model.particles && film.pictures == model.pictures);
  }
  CHECK(survived > 6);
}

}  // namespace motes::test_recovery
