// contact: many steps compared with an independent simulation in double precision, which computes each pair once; and
// what particles remember of their contacts, for any order in memory and any of them as ghosts.
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "interactions/kinds/families.h"
#include "interactions/scratch.h"
#include "particles/digest.h"
#include "particles/store.h"
#include "support/check.h"
#include "support/crowds.h"
#include "support/isas.h"

namespace motes::test_contact {
using test::Dice;
using test::Flock;
using test::Law;

namespace {

using Vec = std::array<double, 3>;

Vec operator+(Vec a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec operator-(Vec a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec operator*(Vec a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec along_surface(const Vec& v, const Vec& n) { return v - n * dot(v, n); }

struct Grain {
  Vec at{}, velocity{}, spin{};
  double radius = 0, mass = 0;
};

// Grains that all fall to the origin.
struct Heap {
  std::vector<Grain> grains;
  std::map<std::pair<std::size_t, std::size_t>, std::pair<Vec, Vec>> springs;  // of the first of two: slid, rolled

  static constexpr double kFall = 3;  // 1/s2

  // Returns the pull of a spring along the surface with its damper, within Coulomb's limit.
  static Vec held(Vec& at, const Vec& speed, double stiffness, double damper, double limit, double step) {
    at = at + speed * step;
    Vec pull = at * stiffness + speed * damper;
    const double length = std::sqrt(dot(pull, pull));
    if (length <= limit) return pull;
    pull = pull * (limit / length);
    at = (pull - speed * damper) * (1 / stiffness);
    return pull;
  }

  void advance(const Law& law) {
    const double step = double{law.step};
    std::vector<Vec> push(grains.size()), turn(grains.size());
    std::map<std::pair<std::size_t, std::size_t>, std::pair<Vec, Vec>> after;
    for (std::size_t i = 0; i < grains.size(); ++i) {
      for (std::size_t j = i + 1; j < grains.size(); ++j) {
        const Vec r = grains[j].at - grains[i].at;
        if (std::sqrt(dot(r, r)) < grains[i].radius + grains[j].radius) touch(law, i, j, push, turn, after);
      }
    }
    springs = after;
    for (std::size_t i = 0; i < grains.size(); ++i) {
      Grain& g = grains[i];
      g.velocity = g.velocity + push[i] * (step / g.mass) - g.at * (kFall * step);
      g.spin = g.spin + turn[i] * (step / (0.4 * g.mass * g.radius * g.radius));
      g.at = g.at + g.velocity * step;
    }
  }

  void touch(const Law& law, std::size_t i, std::size_t j, std::vector<Vec>& push, std::vector<Vec>& turn,
             std::map<std::pair<std::size_t, std::size_t>, std::pair<Vec, Vec>>& after) {
    const Grain &a = grains[i], &b = grains[j];
    const Vec r = b.at - a.at;
    const double d = std::sqrt(dot(r, r));
    const Vec n = r * (1 / d);
    const double overlap = a.radius + b.radius - d;
    const double mass = a.mass * b.mass / (a.mass + b.mass);
    const auto given = actions::numbers_of<actions::numbers::contact>(law.action);
    const double stiffness = given.stiffness;
    const double l = std::log(given.restitution);
    const double damper = -2 * l / std::sqrt(M_PI * M_PI + l * l) * std::sqrt(stiffness * mass);
    const Vec apart = b.velocity - a.velocity;
    const double out = stiffness * overlap - damper * dot(apart, n);
    const double pressed = std::max(0.0, out);
    const double arm = a.radius - overlap / 2, other_arm = b.radius - overlap / 2;
    const Vec slide = along_surface(apart, n) - cross(a.spin * arm + b.spin * other_arm, n);
    auto [slid, rolled] = springs[{i, j}];
    slid = along_surface(slid, n);
    rolled = along_surface(rolled, n);
    const auto step = double{law.step};
    const double along = stiffness * 2 / 7;
    const Vec drag = held(slid, slide, along, damper / 2, given.friction * pressed, step);
    const double both = a.radius * b.radius / (a.radius + b.radius);
    const Vec brake =
        held(rolled, cross(a.spin - b.spin, n) * both, along, damper / 2, given.rolling_friction * pressed, step);
    push[i] = push[i] + drag - n * out;
    push[j] = push[j] - drag + n * out;
    const Vec twist = cross(n, brake) * both;
    turn[i] = turn[i] + cross(n, drag) * arm - twist;
    turn[j] = turn[j] + cross(n, drag) * other_arm + twist;
    after[{i, j}] = {slid, rolled};
  }
};

// The same grains, computed by the kernels.
struct Kernels {
  Flock flock;
  test::Remembered touches;
  std::uint64_t pairs = 0;

  void shuffle(Dice& dice) {
    std::vector<std::size_t> order(flock.size());
    std::iota(order.begin(), order.end(), 0);
    test::shuffle(order, dice);
    test::Remembered moved;
    for (const std::size_t i : order) moved.push_back(touches[i]);
    flock = test::taken(flock, order, flock.own);
    touches = std::move(moved);
  }

  void advance(Law law, std::uint32_t now, const test::MeetingBuild& build) {
    law.now = now;
    law.skin = now % 2 == 0;
    const test::Heard heard = test::heard(build, law, flock, flock, threads::alone(), touches);
    touches = heard.touches;
    pairs += heard.pairs;
    for (std::size_t i = 0; i < flock.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        float& at = flock.column[c][i];
        float& velocity = flock.column[static_cast<std::size_t>(interactions::velocity_x) + c][i];
        velocity = heard.out[c][i] - at * static_cast<float>(Heap::kFall) * law.step;
        flock.column[static_cast<std::size_t>(interactions::spin_x) + c][i] = heard.out[3 + c][i];
        at += velocity * law.step;
      }
    }
  }

  std::size_t index_of(std::uint64_t id) const {
    return static_cast<std::size_t>(std::find(flock.ids.begin(), flock.ids.end(), id) - flock.ids.begin());
  }
};

Kernels grains(std::size_t count, std::uint64_t seed) {
  Kernels made{test::random_flock(count, 0.45f, seed), test::Remembered(count)};
  for (std::size_t i = 0; i < count; ++i) made.flock.ids[i] = i;
  return made;
}

Heap heap_of(const Flock& flock) {
  Heap heap;
  for (std::size_t i = 0; i < flock.size(); ++i) {
    const auto three = [&](int first) {
      Vec v;
      for (std::size_t c = 0; c < 3; ++c) v[c] = double{flock.column[static_cast<std::size_t>(first) + c][i]};
      return v;
    };
    heap.grains.push_back({three(interactions::at_x), three(interactions::velocity_x), three(interactions::spin_x),
                           double{flock.column[interactions::radius][i]},
                           1 / double{flock.column[interactions::inverse_mass][i]}});
  }
  return heap;
}

Law slow_law(double stiffness = 2000) {
  Law law = test::contact_law(0.25f, stiffness);
  law.step = 1.0f / 1024;
  return law;
}

}  // namespace

TEST(grains_move_and_turn_as_in_double_precision) {
  Dice dice(3);
  Kernels kernels = grains(150, 11);
  Heap heap = heap_of(kernels.flock);
  const Law law = slow_law();
  for (std::uint32_t step = 5; step < 85; ++step) {
    kernels.shuffle(dice);
    kernels.advance(law, step, test::meeting_builds()[step % test::meeting_builds().size()]);
    heap.advance(law);
  }
  CHECK(kernels.pairs > 15000);
  double farthest = 0;
  for (std::size_t i = 0; i < heap.grains.size(); ++i) {
    const std::size_t k = kernels.index_of(i);
    for (std::size_t c = 0; c < 3; ++c) {
      CHECK_NEAR(double{kernels.flock.column[c][k]}, heap.grains[i].at[c], 2e-4);
      CHECK_NEAR(double{kernels.flock.column[interactions::velocity_x + c][k]}, heap.grains[i].velocity[c], 1e-2);
      CHECK_NEAR(double{kernels.flock.column[interactions::spin_x + c][k]}, heap.grains[i].spin[c], 0.1);
      farthest = std::max(farthest, std::abs(heap.grains[i].spin[c]));
    }
  }
  CHECK(farthest > 5);  // the grains do turn
}

TEST(the_order_in_memory_and_the_build_do_not_show_in_many_steps) {
  std::vector<particles::Digest> all;
  for (const std::uint64_t seed : {1, 2}) {
    Dice dice(seed);
    Kernels kernels = grains(300, 12);
    for (std::uint32_t step = 1; step < 40; ++step) {
      if (seed == 2) kernels.shuffle(dice);
      kernels.advance(slow_law(), step, test::meeting_builds()[seed == 1 ? 0 : step % test::meeting_builds().size()]);
    }
    const particles::Schema schema;
    particles::Store store(schema);
    store.grow(kernels.flock.size());
    for (std::size_t i = 0; i < kernels.flock.size(); ++i) {
      store.set_id(i, kernels.flock.ids[i]);
      for (int c = 0; c < 3; ++c) store.writable_plane(particles::position, c)[i] = kernels.flock.column[c][i];
      store.set_touches(i, kernels.touches[i]);
    }
    all.push_back(particles::digest(store));
  }
  CHECK(all[0] == all[1]);
}

// A list and its near pairs are kept; the reference looks at all pairs anew in each step.
TEST(near_pairs_are_found_anew_when_a_grain_leaves_its_course) {
  Dice dice(4);
  Kernels kernels = grains(200, 15);
  const test::MeetingBuild& build = test::meeting_builds().back();
  Law law = slow_law();
  law.step = 1.0f / 8192;
  law.skin = true;
  test::Arranged arranged(kernels.flock, law.reach, threads::alone());
  law.now = 1;
  interactions::NeighbourList kept =
      test::listed(build, law, kernels.flock, arranged, kernels.touches, threads::alone());
  std::uint64_t pairs = 0;
  for (std::uint32_t now = 1; now < 18; ++now) {
    law.now = now;
    const test::Heard anew = test::heard(build, law, kernels.flock, kernels.flock, threads::alone(), kernels.touches);
    const test::Heard heard = test::touched(kept, law, kernels.flock, threads::alone());
    CHECK(heard.out == anew.out);
    CHECK(heard.touches == anew.touches);
    pairs += heard.pairs;
    kernels.touches = heard.touches;
    for (std::size_t i = 0; i < kernels.flock.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        float& velocity = kernels.flock.column[static_cast<std::size_t>(interactions::velocity_x) + c][i];
        velocity = heard.out[c][i];
        if (now == 7) velocity = dice.between(-6, 6);
        kernels.flock.column[static_cast<std::size_t>(interactions::spin_x) + c][i] = heard.out[3 + c][i];
        kernels.flock.column[c][i] += velocity * law.step;
      }
    }
  }
  CHECK(pairs > 2000);
}

TEST(what_was_not_touched_in_the_last_step_is_forgotten) {
  Kernels kernels = grains(100, 13);
  kernels.advance(slow_law(), 10, test::meeting_builds()[0]);
  Kernels later = kernels, fresh = kernels;
  for (auto& touches : fresh.touches) touches.clear();
  Kernels next = kernels;
  later.advance(slow_law(), 12, test::meeting_builds()[0]);
  fresh.advance(slow_law(), 12, test::meeting_builds()[0]);
  next.advance(slow_law(), 11, test::meeting_builds()[0]);
  CHECK(later.flock.column == fresh.flock.column);
  CHECK(next.flock.column != fresh.flock.column);
}

TEST(springs_that_are_too_stiff_for_the_step_are_softened) {
  const Law law = slow_law(1e9);
  Kernels kernels = grains(150, 14);
  for (std::uint32_t step = 1; step < 200; ++step) kernels.advance(law, step, test::meeting_builds()[0]);
  for (const float v : kernels.flock.column[interactions::velocity_x]) CHECK(std::abs(v) < 500);
}

TEST(a_step_is_too_long_for_the_lightest_two_that_touch) {
  const particles::Schema schema;
  particles::Store store(schema);
  store.grow(3);
  const float masses[3] = {2, 0.25f, 0};  // the last one touches no other
  for (std::size_t i = 0; i < 3; ++i) store.writable_plane(particles::mass, 0)[i] = masses[i];
  interactions::Scratch scratch;
  interactions::Meeting meeting;
  meeting.scratch = &scratch;
  meeting.pool = &threads::alone();
  meeting.sides[0].store = &store;
  const auto substeps = [&](const Law& law, double frame_s, bool measured = true) {
    meeting.sides[0].action = &law.action;
    const auto act = interactions::begin(meeting);
    return act->substeps(measured ? act->own() : interactions::Agreement{}, frame_s);
  };
  const Law law = slow_law(1000);
  const double longest = std::sqrt(0.39 * 0.125 / 1000);
  CHECK(substeps(law, 3.001 * longest) == 4);
  CHECK(substeps(law, 2.999 * longest) == 3);
  const double of_a_kilogram = std::sqrt(0.39 * 0.5 / 1000);
  CHECK(substeps(law, 0.99 * of_a_kilogram, false) == 1);
  CHECK(substeps(test::fluid_law(1), 1) == 0);
}

}  // namespace motes::test_contact
