// Neighbours that balance without the manager, on simulated ranks: all ranks know the same cuts before each frame, the
// bits are those of a run on one rank, no rank plans, and all ranks name a rank that fails.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "balance/named.h"
#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "support/check.h"
#include "support/falling_source.h"
#include "support/forwarding_transport.h"
#include "support/owners.h"

namespace motes::test_orders_of_neighbours {
using comm::Phase;
using comm::SimulatedRank;

namespace {

constexpr int kFrames = 6;
constexpr int kFails = 3;  // the frame in which a rank fails

struct Way {
  int ranks = 1;
  bool shared = false;
  bool balances = true;
  bool over_all = false;
  engine::Births births = engine::Births::manager;
  engine::Combine combine = engine::Combine::together;
  int fan_out = 8;
  bool follows = false;  // children share their parents' domains
  bool children_born = false;  // some children come from their own source
  int fails = -1;  // the rank whose callback throws
  int differs = -1;  // the rank that makes a different call than a frame
};

struct Sent {
  int from, to;
  Phase phase;
};

class Counting final : public test::Forwarding {
 public:
  Counting(std::unique_ptr<Transport> under, std::vector<Sent>& sent) : Forwarding(std::move(under)), sent_(sent) {}
  void send(int to, Phase phase, std::shared_ptr<const comm::Message> message) override {
    sent_.push_back({rank(), to, phase});
    Forwarding::send(to, phase, std::move(message));
  }

 private:
  std::vector<Sent>& sent_;
};

// What all ranks saw: their digests, and the cuts of both systems that each knew between frames.
struct Film {
  std::vector<std::string> digests;
  std::map<int, std::vector<std::vector<float>>> cuts;  // by rank
  std::vector<Sent> sent;
  std::map<int, std::string> ends;
};

void record(engine::Engine& engine, const Way& way) {
  recording::Spawn spawn;
  spawn.into = 1;
  spawn.on = recording::Spawn::On::collision;
  spawn.count = 2;
  engine.record(0, test::falling_source(80));
  engine.record(0, spawn);
  engine.record(0, actions::make(actions::numbers::gravity<>{.acceleration = {0, -9.81, 0}}));
  engine.record(0,
                actions::Action{actions::Kind::bounce, {0.5, 0.1, 0, 1}, {{shapes::Kind::plane, {0, 0, 0, 0, 1, 0}}}});
  if (way.fails >= 0) engine.record(0, recording::Callback{"look", 0, {}, {}});
  engine.record(0, actions::make(actions::numbers::kill_old<>{.age_limit = 0.3}));
  engine.record(0, actions::make(actions::numbers::move<>{.rotational = 1}));
  if (way.children_born) engine.record(1, test::falling_source(80));
  engine.record(1, actions::make(actions::numbers::kill_old<>{.age_limit = 0.1}));
  engine.record(1, actions::make(actions::numbers::move<>{.rotational = 1}));
}

engine::Settings settings(const Way& way) {
  engine::Settings settings;
  settings.seed = 11;
  settings.births = way.births;
  settings.combine = way.combine;
  settings.fan_out = way.fan_out;
  const auto policy = balance::policy_named("Diffusive(threshold=0.01, min_particles=2, manager=False)");
  policy->speeds.min_particles = 1;
  policy->over_all = way.over_all;
  if (way.balances) settings.policy = policy;
  settings.costs.act.fill(2000);
  return settings;
}

void play(SimulatedRank& self, const Way& way, Film& film) {
  const roles::Cast cast = way.shared ? roles::cast_shared(way.ranks) : roles::cast_auto(way.ranks);
  auto transport = std::make_unique<Counting>(self.transport(), film.sent);
  engine::Engine engine(std::make_unique<comm::Communicator>(std::move(transport), comm::Watch{}), cast, settings(way));
  recording::SystemDefinition definition;
  definition.space = {domains::Space::Kind::finite, -3.2, 0.8};
  definition.name = "parents";
  engine.add_system(definition);
  definition.name = "children";
  if (way.follows) definition.domains_of = 0;
  engine.add_system(definition);
  engine.on_callback([&](const engine::Call&) {
    const bool now = engine.frame() == kFails && self.rank() == way.fails;
    if (now) throw std::runtime_error("the callback broke");
  });
  engine.start();
  for (int i = 0; i < kFrames; ++i) {
    if (i + 1 < kFrames) record(engine, way);  // particles that no action moves follow the cuts, too
    if (i == kFails && self.rank() == way.differs) engine.digest();
    engine.run_frame(std::nullopt);
    test::check_owners(engine);
    const std::string digest = particles::combine(engine.digest()).text();
    if (self.rank() == 0) film.digests.push_back(digest);
    for (const int system : {0, 1}) film.cuts[self.rank()].push_back(engine.system(system).domains.cuts());
  }
  engine.finish();
}

Film run(const Way& way, std::uint64_t seed, std::uint64_t timing) {
  Film film;
  comm::simulate({.ranks = way.ranks, .seed = seed, .timing_seed = timing}, [&](SimulatedRank& self) {
    try {
      play(self, way, film);
    } catch (const engine::Agreed& agreed) {
      const engine::Verdict& verdict = agreed.verdict();
      film.ends[self.rank()] = "rank " + std::to_string(verdict.failed_rank) + ": " + verdict.failure.text;
    } catch (const std::runtime_error& error) {
      film.ends[self.rank()] = error.what();
    }
  });
  return film;
}

Way way_of(std::uint64_t seed) {
  Way way;
  const int ranks[] = {2, 3, 4, 5, 7, 8, 12};
  way.ranks = ranks[seed % 7];
  way.shared = seed % 2 == 0;
  way.over_all = seed / 2 % 3 == 1;
  way.births = seed / 3 % 2 == 0 ? engine::Births::calculators : engine::Births::manager;
  way.combine = static_cast<engine::Combine>(seed % 3);
  way.fan_out = 1 + static_cast<int>(seed % 4);
  way.follows = seed % 5 == 4;
  return way;
}

}  // namespace

TEST(neighbours_without_a_manager_give_the_same_bits_and_all_ranks_the_same_cuts) {
  const Film alone = run({}, 0, 0);
  CHECK(std::set<std::string>(alone.digests.begin(), alone.digests.end()).size() == kFrames - 1);
  std::size_t moved = 0;
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    const Way way = way_of(seed);
    const Film film = run(way, seed, seed);
    CHECK(film.ends.empty() && film.digests == alone.digests);
    for (const auto& [rank, cuts] : film.cuts) CHECK(cuts == film.cuts.at(0));
    const std::set<std::vector<float>> different(film.cuts.at(0).begin(), film.cuts.at(0).end());
    moved += static_cast<std::size_t>(different.size() > 2);
  }
  CHECK(moved > 60);
}

TEST(what_neighbours_decide_repeats_with_the_simulated_time) {
  Way way;
  way.ranks = 6;
  const Film model = run(way, 0, 3);
  for (std::uint64_t seed = 1; seed < 20; ++seed) CHECK(run(way, seed, 3).cuts == model.cuts);
  CHECK(run(way, 0, 4).cuts != model.cuts);
}

TEST(neighbours_without_a_manager_hear_each_other_and_no_plan) {
  for (const int ranks : {1, 2, 3, 5, 9}) {
    for (const bool shared : {false, true}) {
      Way way;
      way.ranks = ranks;
      way.shared = shared;
      const roles::Cast cast = shared ? roles::cast_shared(ranks) : roles::cast_auto(ranks);
      std::size_t loads = 0;
      for (const Sent& sent : run(way, 1, 1).sent) {
        CHECK(sent.phase != Phase::plan && sent.phase != Phase::proposals);
        if (sent.phase != Phase::loads) continue;
        CHECK(std::abs(cast.calculator_of(sent.from) - cast.calculator_of(sent.to)) == 1);
        ++loads;
      }
      CHECK(loads == 2 * kFrames * (cast.calculators.size() - 1));
    }
  }
}

TEST(a_rank_that_fails_among_neighbours_without_a_manager_is_named_by_all) {
  std::uint64_t seed = 0;
  for (const int ranks : {2, 3, 5, 8}) {
    for (int rank = 0; rank < ranks; ++rank) {
      Way way = way_of(++seed);
      way.ranks = ranks;
      way.shared = true;
      way.fails = rank;
      Film film = run(way, seed, seed);
      for (int r = 0; r < ranks; ++r) {
        const std::string text = "the callback broke";
        CHECK(film.ends[r] == (r == rank ? text : "rank " + std::to_string(rank) + ": " + text));
      }
      way.fails = -1;
      way.differs = rank;
      film = run(way, seed, seed);
      for (int r = 0; r < ranks; ++r) {
        const bool named = film.ends[r].find("(here: rank " + std::to_string(rank)) != std::string::npos;
        CHECK(named || (ranks == 2 && film.ends[r].find("(here: rank ") != std::string::npos));
      }
    }
  }
}

// Calculators create the births of the second round while the first round's messages travel: a rank outside the frame
// that waited for the first verdict at once would block all.
TEST(a_rank_that_asks_for_something_else_is_named_where_rounds_overlap) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Way way = way_of(seed);
    way.ranks = 4;
    way.shared = true;
    way.balances = false;
    way.births = engine::Births::calculators;
    way.combine = engine::Combine::overlapped;
    way.children_born = true;
    way.differs = static_cast<int>(seed % 4);
    Film film = run(way, seed, seed);
    const std::string named = "(here: rank " + std::to_string(way.differs);
    for (int r = 0; r < way.ranks; ++r) CHECK(film.ends[r].find(named) != std::string::npos);
  }
}

// A difference is evened out once, although loads are compared before the particles of the last cuts have arrived.
TEST(cuts_of_neighbours_without_a_manager_settle_where_times_are_equal) {
  std::vector<double> times(16);
  std::vector<std::vector<float>> cuts;
  comm::simulate({.ranks = 16, .variation = 0}, [&](SimulatedRank& self) {
    engine::Settings of_rank = settings({});
    of_rank.speed = self.rank() < 8 ? 1 : 0.5;
    const auto policy = balance::policy_named("Diffusive(threshold=0.002, rate=1, min_particles=1, manager=False)");
    policy->speeds.min_particles = 1;
    of_rank.policy = policy;
    engine::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}), roles::cast_shared(16),
                          of_rank);
    recording::SystemDefinition definition;
    definition.space = {domains::Space::Kind::finite, -4, 4};
    engine.add_system(definition);
    engine.start();
    for (int i = 0; i < 150; ++i) {
      recording::Burst burst;
      burst.shape = {shapes::Kind::box, {-4, 0, 0, 4, 1, 1}};
      burst.count = 20000;
      if (i == 0) engine.record(0, burst);
      engine.record(0, actions::make(actions::numbers::gravity<>{.acceleration = {0, -9.81, 0}}));
      engine.run_frame(std::nullopt);
      if (self.rank() == 0) cuts.push_back(engine.system(0).domains.cuts());
    }
    times[static_cast<std::size_t>(self.rank())] = static_cast<double>(engine.seen(0).count) / of_rank.speed;
    engine.finish();
  });
  CHECK(*std::max_element(times.begin(), times.end()) < 1.3 * *std::min_element(times.begin(), times.end()));
  for (std::size_t cut = 0; cut < cuts[0].size(); ++cut) {
    float way = 0;
    for (std::size_t i = 1; i < cuts.size(); ++i) way += std::abs(cuts[i][cut] - cuts[i - 1][cut]);
    CHECK(way < 0.1f + 1.1f * (cuts.back()[cut] - cuts.front()[cut]));
  }
}

}  // namespace motes::test_orders_of_neighbours
