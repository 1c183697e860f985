// Laws between particles: compared with all pairs in double precision, the same bits from every build, and with any of
// the particles as ghosts.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "support/check.h"
#include "support/crowds.h"
#include "support/isas.h"

namespace motes::test_meetings {
using actions::Kind;
using test::Dice;
using test::Flock;
using test::Heard;
using test::Law;
using test::meeting_builds;

namespace {

using Vec = std::array<double, 3>;

Vec minus(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The effect on one particle: the sum of terms, and how large they are together.
struct Sum {
  Vec sum{};
  double size = 0;
  double weight = 0;
  int touching = 0;

  void add(const Vec& term) {
    for (std::size_t c = 0; c < 3; ++c) sum[c] += term[c];
    size += std::sqrt(dot(term, term));
  }
};

Vec triple(const Flock& flock, int first, std::size_t i) {
  Vec found;
  for (std::size_t c = 0; c < 3; ++c)
    found[c] = static_cast<double>(flock.column[static_cast<std::size_t>(first) + c][i]);
  return found;
}

double number(const Flock& flock, int column, std::size_t i) {
  return static_cast<double>(flock.column[static_cast<std::size_t>(column)][i]);
}

// The formula of Collide's docstring, with restitution.
void add_push(const Law& law, const Flock& a, std::size_t i, const Flock& b, std::size_t j, const Vec& r, double d,
              Sum& sum) {
  const auto given = actions::numbers_of<actions::numbers::collide>(law.action);
  const auto step = double{law.step};
  const double reach =
      law.radii ? number(a, interactions::radius, i) + number(b, interactions::radius, j) : double{law.reach};
  if (d >= reach) return;
  ++sum.touching;
  const Vec apart = minus(triple(b, interactions::velocity_x, j), triple(a, interactions::velocity_x, i));
  const Vec n = {r[0] / d, r[1] / d, r[2] / d};
  const double along = dot(apart, n);
  double out = (reach - d) / step;
  const double slow = 0.8 * given.sleep;
  if (given.restitution > 0 && along < -slow) out = std::max(out, -(1 + given.restitution) * along);
  const Vec slide = {apart[0] - n[0] * along, apart[1] - n[1] * along, apart[2] - n[2] * along};
  const double speed = std::sqrt(dot(slide, slide));
  const double stop = std::min(speed, given.friction * out);
  const double busy = std::max(number(a, interactions::contacts, i), number(b, interactions::contacts, j));
  double part = std::min(1.0, 2 / std::max(busy, 1.0)) / 2;
  if (law.masses) {
    const double own = number(a, interactions::inverse_mass, i);
    part = 2 * part * own / (own + number(b, interactions::inverse_mass, j));
  }
  Vec term;
  for (std::size_t c = 0; c < 3; ++c) term[c] = part * ((speed > 0 ? slide[c] / speed * stop : 0) - n[c] * out);
  sum.add(term);
}

Sum sum_of(const Law& law, const Flock& a, std::size_t i, const Flock& b) {
  Sum sum;
  for (std::size_t j = 0; j < b.size(); ++j) {
    const Vec r = minus(triple(b, interactions::at_x, j), triple(a, interactions::at_x, i));
    const double d = std::sqrt(dot(r, r));
    if (!(d > 0 && d < double{law.reach})) continue;
    if (law.action.kind == Kind::collide) {
      add_push(law, a, i, b, j, r, d, sum);
      continue;
    }
    ++sum.touching;
    const double weight = law.action.numbers[0] * double{law.step} / (d * d + law.action.numbers[1]);
    if (law.action.kind == Kind::gravitate) {
      sum.add({r[0] * weight / d, r[1] * weight / d, r[2] * weight / d});
    } else {
      const Vec apart = minus(triple(b, interactions::velocity_x, j), triple(a, interactions::velocity_x, i));
      sum.add({apart[0] * weight, apart[1] * weight, apart[2] * weight});
      sum.weight += weight;
    }
  }
  return sum;
}

double sleep_of(const Law& law) { return actions::numbers_of<actions::numbers::collide>(law.action).sleep; }

// Returns what the kernel should give for a particle, from all pairs.
Vec said_of(const Law& law, const Flock& a, std::size_t i, const Sum& sum) {
  if (law.action.kind == Kind::gravitate) return sum.sum;
  Vec now = triple(a, interactions::velocity_x, i);
  const double part = law.action.kind == Kind::match_velocity ? 1 / std::max(1.0, sum.weight) : 1;
  for (std::size_t c = 0; c < 3; ++c) now[c] += sum.sum[c] * part;
  const bool sleeps =
      law.action.kind == Kind::collide && sum.touching > 1 && dot(now, now) < std::pow(sleep_of(law), 2);
  return sleeps ? Vec{} : now;
}

// Compares results with all pairs; returns how many pairs there are.
std::uint64_t check_against_pairs(const Law& law, const Flock& a, const Flock& b, const Heard& heard) {
  std::uint64_t pairs = 0;
  for (std::size_t i = 0; i < a.own; ++i) {
    const Sum sum = sum_of(law, a, i, b);
    const Vec wanted = said_of(law, a, i, sum);
    const Vec value = triple(a, interactions::velocity_x, i);
    const double size = sum.size + (law.action.kind == Kind::gravitate ? 0 : std::sqrt(dot(value, value)));
    for (std::size_t c = 0; c < 3; ++c) CHECK_NEAR(double{heard.out[c][i]}, wanted[c], 1e-5 * size);
    if (law.action.kind == Kind::collide) CHECK(heard.out[3][i] == static_cast<float>(sum.touching));
    pairs += static_cast<std::uint64_t>(sum.touching);
  }
  CHECK(heard.pairs == pairs);
  return pairs;
}

Flock cube(std::size_t count, std::uint64_t seed) { return test::random_flock(count, 1.0f, seed); }

bool same(const Heard& a, const Heard& b) { return a.out == b.out && a.touches == b.touches; }

// Some of the particles as this rank's own, and the others within `reach` of them as its ghosts, all shuffled.
struct Share {
  std::vector<std::size_t> of;  // their indices in the whole: own ones first
  Flock flock;
};

Share share_of(const Flock& whole, const std::vector<bool>& own, double reach, Dice& dice) {
  Share share;
  std::vector<std::size_t> ghosts;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (own[i]) share.of.push_back(i);
  }
  for (std::size_t j = 0; j < whole.size(); ++j) {
    const auto near = [&](std::size_t i) {
      const Vec r = minus(triple(whole, interactions::at_x, i), triple(whole, interactions::at_x, j));
      return dot(r, r) <= reach * reach;
    };
    if (!own[j] && std::any_of(share.of.begin(), share.of.end(), near)) ghosts.push_back(j);
  }
  test::shuffle(share.of, dice);
  test::shuffle(ghosts, dice);
  const std::size_t count = share.of.size();
  share.of.insert(share.of.end(), ghosts.begin(), ghosts.end());
  share.flock = test::taken(whole, share.of, count);
  return share;
}

// Divides the particles among some domains: slabs, or at random.
std::vector<std::vector<bool>> divided(const Flock& whole, Dice& dice) {
  const std::size_t domains = 2 + dice.below(4);
  const std::size_t axis = dice.below(4);  // 3: any
  std::vector<float> cuts;
  for (std::size_t k = 1; k < domains; ++k) cuts.push_back(dice.between(-1, 1));
  std::vector<std::vector<bool>> own(domains, std::vector<bool>(whole.size(), false));
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::size_t domain = axis == 3 ? dice.below(domains) : 0;
    for (const float cut : cuts) domain += axis < 3 && whole.column[axis][i] >= cut ? 1 : 0;
    own[domain][i] = true;
  }
  return own;
}

}  // namespace

TEST(laws_between_particles_come_to_all_pairs_in_double_precision) {
  const Flock flock = cube(2000, 1);
  for (const Law& law : test::all_laws()) {
    if (law.action.kind == Kind::contact || law.action.kind == Kind::fluid) continue;  // tested elsewhere
    const std::uint64_t pairs = check_against_pairs(law, flock, flock, test::heard(meeting_builds()[0], law, flock));
    CHECK(pairs > 6000);
  }
}

TEST(two_systems_that_meet_come_to_all_pairs_between_them) {
  const Flock first = cube(900, 2);
  Flock second = cube(1100, 3);
  second.ids = test::numbers(second.size(), 100);  // ids of two systems are unrelated
  for (Law law : test::all_laws()) {
    if (law.action.kind != Kind::collide) continue;
    law.side = 1;
    const std::uint64_t seen =
        check_against_pairs(law, first, second, test::heard(meeting_builds()[0], law, first, second));
    law.side = 2;
    CHECK(seen == check_against_pairs(law, second, first, test::heard(meeting_builds()[0], law, second, first)));
    CHECK(seen > 1500);
  }
}

TEST(all_builds_say_the_same_bits_between_particles) {
  for (const float half : {1.0f, 0.3f, 30.0f}) {  // many neighbours, nearly all, hardly one
    Flock flock = test::random_flock(1500, half, 4);
    for (int c = 0; c < 3; ++c) flock.column[static_cast<std::size_t>(c)][7] = flock.column[c][8];
    flock.column[interactions::at_y][9] = std::nanf("");
    for (const Law& law : test::all_laws()) {
      const Heard narrow = test::heard(meeting_builds()[0], law, flock);
      for (const test::MeetingBuild& build : meeting_builds()) CHECK(same(test::heard(build, law, flock), narrow));
    }
  }
}

TEST(any_of_the_particles_may_be_copies) {
  Dice dice(5);
  const Flock whole = cube(1200, 5);
  for (int round = 0; round < 6; ++round) {
    const std::vector<std::vector<bool>> domains = divided(whole, dice);
    for (const Law& law : test::all_laws()) {
      const double seen = law.action.kind == Kind::fluid ? 2 : 1;  // others' neighbours too
      const double reach = double{law.reach} * (1 + 1e-6) * seen * (round % 2 == 0 ? 1 : 2);
      for (const test::MeetingBuild& build : meeting_builds()) {
        const Heard all = test::heard(build, law, whole);
        std::uint64_t pairs = 0;
        for (const std::vector<bool>& own : domains) {
          const Share share = share_of(whole, own, reach, dice);
          const Heard part = test::heard(build, law, share.flock);
          pairs += part.pairs;
          for (std::size_t k = 0; k < share.flock.own; ++k) {
            for (std::size_t c = 0; c < law.outputs().size(); ++c) CHECK(part.out[c][k] == all.out[c][share.of[k]]);
            CHECK(part.touches[k] == all.touches[share.of[k]]);
          }
        }
        CHECK(pairs == all.pairs);
      }
    }
  }
}

TEST(threads_share_a_law_and_the_bits_stay) {
  const Flock flock = cube(3000, 6);
  threads::Pool three(3, 64);
  for (const Law& law : test::all_laws()) {
    const test::MeetingBuild& build = meeting_builds().back();
    CHECK(same(test::heard(build, law, flock, three), test::heard(build, law, flock)));
  }
}

TEST(momentum_between_particles_is_kept) {
  Flock flock = cube(2000, 7);
  for (const Law& law : test::all_laws()) {
    if (law.action.kind == Kind::match_velocity && law.action.numbers[0] > 2.56)
      continue;  // not kept where weights count for at most 1
    const Heard heard = test::heard(meeting_builds().back(), law, flock);
    Vec sum{};
    double size = 0;
    for (std::size_t i = 0; i < flock.size(); ++i) {
      const double mass = law.masses ? 1 / number(flock, interactions::inverse_mass, i) : 1;
      for (std::size_t c = 0; c < 3; ++c) {
        const double before =
            law.action.kind == Kind::gravitate ? 0 : number(flock, interactions::velocity_x + static_cast<int>(c), i);
        sum[c] += mass * (double{heard.out[c][i]} - before);
        size += mass * std::abs(double{heard.out[c][i]} - before);
      }
    }
    CHECK(size > 1);
    for (const double component : sum) CHECK_NEAR(component, 0, 1e-6 * size);
  }
}

TEST(particles_at_one_place_part_in_opposite_directions) {
  Dice dice(8);
  for (int round = 0; round < 200; ++round) {
    Flock pair = test::random_flock(2, 1, dice.word());
    for (int c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < 2; ++i) {
        pair.column[static_cast<std::size_t>(c)][i] = 0.5f;
        pair.column[static_cast<std::size_t>(interactions::velocity_x + c)][i] = 0;
      }
    }
    pair.column[interactions::contacts] = {0, 0};
    pair.ids = {dice.word() % 1000, 1000 + dice.word() % 1000};
    if (dice.coin()) std::swap(pair.ids[0], pair.ids[1]);
    const Law law = test::collision(0.25f, 0, false, false);
    const Heard both = test::heard(meeting_builds().back(), law, pair);
    double apart = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      CHECK(both.out[c][0] == -both.out[c][1]);
      apart += std::pow(double{both.out[c][0]} - double{both.out[c][1]}, 2);
    }
    CHECK_NEAR(std::sqrt(apart) * double{law.step}, 0.25, 1e-5);  // they will just not overlap
    CHECK(both.out[3][0] == 1 && both.out[3][1] == 1);
    for (const std::size_t own : {std::size_t{0}, std::size_t{1}}) {  // the same if the other one is a ghost
      const Heard one = test::heard(meeting_builds()[0], law, test::taken(pair, {own, 1 - own}, 1));
      for (std::size_t c = 0; c < 4; ++c) CHECK(one.out[c][0] == both.out[c][own]);
    }
    for (const Law& blind : {test::gravitation(0.25f), test::matching(0.25f, 1e-3f)}) {
      const Heard nothing = test::heard(meeting_builds().back(), blind, pair);
      for (std::size_t c = 0; c < 3; ++c) CHECK(nothing.out[c][0] == 0 && nothing.out[c][1] == 0);
    }
  }
}

TEST(a_crowd_at_one_place_parts_in_any_build_and_with_any_copies) {
  Dice dice(9);
  Flock crowd = cube(60, 9);
  for (std::size_t i = 0; i < 40; ++i) {
    for (std::size_t c = 0; c < 3; ++c) crowd.column[c][i] = i < 20 ? 0.125f : -0.25f;
  }
  for (const bool masses : {false, true}) {
    const Law law = test::collision(0.5f, 0.5f, masses, masses);
    const Heard all = test::heard(meeting_builds()[0], law, crowd);
    Vec momentum{};
    for (std::size_t i = 0; i < crowd.size(); ++i) {
      const double mass = masses ? 1 / number(crowd, interactions::inverse_mass, i) : 1;
      for (std::size_t c = 0; c < 3; ++c)
        momentum[c] += mass * (double{all.out[c][i]} - triple(crowd, interactions::velocity_x, i)[c]);
    }
    for (const double component : momentum) CHECK_NEAR(component, 0, 1e-3);
    CHECK(all.out[3][0] >= 19);
    for (const test::MeetingBuild& build : meeting_builds()) {
      CHECK(same(test::heard(build, law, crowd), all));
      for (const std::vector<bool>& own : divided(crowd, dice)) {
        const Share share = share_of(crowd, own, 1, dice);
        const Heard part = test::heard(build, law, share.flock);
        for (std::size_t k = 0; k < share.flock.own; ++k) {
          for (std::size_t c = 0; c < 4; ++c) CHECK(part.out[c][k] == all.out[c][share.of[k]]);
        }
      }
    }
  }
}

TEST(particles_without_a_place_are_seen_by_nobody) {
  Flock flock = cube(500, 10);
  Flock sane = flock;
  constexpr std::size_t kLost = 20;
  for (std::size_t i = 0; i < kLost; ++i) flock.column[i % 3][i] = i < 10 ? std::nanf("") : INFINITY;
  std::vector<std::size_t> rest;
  for (std::size_t i = kLost; i < flock.size(); ++i) rest.push_back(i);
  sane = test::taken(sane, rest, rest.size());
  for (const Law& law : test::all_laws()) {
    const Heard with = test::heard(meeting_builds().back(), law, flock);
    const Heard without = test::heard(meeting_builds().back(), law, sane);
    CHECK(with.pairs == without.pairs);
    for (std::size_t k = 0; k < rest.size(); ++k) {
      for (std::size_t c = 0; c < law.outputs().size(); ++c) CHECK(with.out[c][rest[k]] == without.out[c][k]);
    }
  }
}

}  // namespace motes::test_meetings
