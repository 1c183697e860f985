// Meetings of stores: which particles change, what must be known of other ranks' particles, and balls that hit each
// other.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "interactions/kinds/families.h"
#include "interactions/scratch.h"
#include "particles/digest.h"
#include "program/program.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_meetings_of_stores {
using actions::Action;
using actions::Kind;
using interactions::Agreement;
using interactions::Ghosts;
using particles::Store;
using test::Dice;

namespace {

const particles::Schema kSchema;
constexpr float kDt = 1.0f / 256;

struct Collision {
  double radius = 0, restitution = 0, friction = 0, sleep = 0, other_radius = 0;
  bool two = false;

  Action action() const {
    Action made = actions::make(actions::numbers::collide<>{.radius = radius,
                                                            .restitution = restitution,
                                                            .friction = friction,
                                                            .sleep = sleep,
                                                            .other_radius = other_radius});
    if (two) made.partner = {1};
    return made;
  }
};

Action gravitation(double radius) {
  return actions::make(actions::numbers::gravitate<>{.magnitude = 0.5, .epsilon = 1e-3, .max_radius = radius});
}
Action matching(double radius) {
  return actions::make(actions::numbers::match_velocity<>{.magnitude = 0.5, .epsilon = 1e-3, .max_radius = radius});
}
Action spin_matching(double radius) {
  return actions::make(
      actions::numbers::match_rotational_velocity<>{.magnitude = 0.5, .epsilon = 1e-3, .max_radius = radius});
}

Action contact() {
  return actions::make(
      actions::numbers::contact<>{.restitution = 0.5, .friction = 0.5, .stiffness = 20, .rolling_friction = 0.25});
}

Action fluid() {
  return actions::make(actions::numbers::fluid<>{.rest_density = 100, .viscosity = 0.01, .radius = 0.2, .cohesion = 1});
}

// A meeting of stores on one rank.
struct Met {
  interactions::Scratch scratch;
  interactions::Meeting meeting;
  particles::Periods none;

  Met(const Action& action, std::uint32_t now, Store& first, Store* second = nullptr) {
    meeting.count = second == nullptr ? 1 : 2;
    for (interactions::Side& side : meeting.sides) side.action = &action;
    meeting.sides[0].store = &first;
    meeting.sides[1].store = second;
    meeting.periods = &none;
    meeting.step.number = now;
    meeting.step.dt = kDt;
    meeting.scratch = &scratch;
    meeting.pool = &threads::alone();
  }
};

void set(Store& store, int attribute, std::size_t i, std::initializer_list<float> values) {
  int c = 0;
  for (const float value : values) store.writable_plane(attribute, c++)[i] = value;
}

float value(const Store& store, int attribute, std::size_t i, int c = 0) {
  const float* plane = store.plane(attribute, c);
  return plane != nullptr ? plane[i] : store.uniform_value(attribute)[static_cast<std::size_t>(c)];
}

// Runs a meeting on one rank with all particles.
interactions::InteractionCounts meet(const Action& action, Store& first, Store* second = nullptr,
                                     const std::vector<std::uint8_t>* chosen = nullptr) {
  Met met(action, 1, first, second);
  met.meeting.sides[0].chosen = chosen;
  const auto act = interactions::begin(met.meeting);
  return act->act(act->own());
}

void move(Store& store) {
  program::ListResult outcome;
  program::Program({actions::make(actions::numbers::move<>{})}, 0)
      .run(store, 0, 0, {0, 1, static_cast<double>(kDt), 0}, {}, {}, outcome);
}

// Balls on the x axis that approach each other at the origin.
struct Ball {
  float at, speed, mass = 1, width = 0.2f;
};

Store balls(const std::vector<Ball>& all) {
  Store store(kSchema);
  store.grow(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    store.set_id(i, i);
    set(store, particles::position, i, {all[i].at, 0.5f, -0.25f});
    set(store, particles::velocity, i, {all[i].speed, 0, 0});
    set(store, particles::mass, i, {all[i].mass});
    set(store, particles::size, i, {all[i].width, all[i].width, all[i].width});
  }
  return store;
}

// Returns the balls' speeds after they have met.
std::vector<float> speeds_after(const Collision& collision, const std::vector<Ball>& all) {
  Store store = balls(all);
  for (int step = 0; step < 60; ++step) {
    meet(collision.action(), store);
    move(store);
  }
  std::vector<float> speeds;
  for (std::size_t i = 0; i < all.size(); ++i) {
    speeds.push_back(value(store, particles::velocity, i));
    for (const int c : {1, 2}) CHECK_NEAR(double{value(store, particles::velocity, i, c)}, 0, 1e-6);
  }
  for (std::size_t i = 1; i < all.size(); ++i) {
    const float apart = value(store, particles::position, i) - value(store, particles::position, i - 1);
    const double radii = collision.radius > 0 ? 2 * collision.radius : 0.5 * double{all[i].width + all[i - 1].width};
    CHECK(double{apart} > radii * (1 - 1e-5));
  }
  return speeds;
}

Store random_store(std::size_t count, Dice& dice) {
  Store store(kSchema);
  store.grow(count);
  for (std::size_t i = 0; i < count; ++i) {
    store.set_id(i, i * 7 % 1009);
    const auto near = [&](float half) { return dice.between(-half, half); };
    set(store, particles::position, i, {near(1), near(1), near(1)});
    set(store, particles::velocity, i, {near(9), near(9), near(9)});
    set(store, particles::rotational_velocity, i, {near(2), near(2), near(2)});
    set(store, particles::size, i, {dice.between(0.05f, 0.2f), 1, 1});
    set(store, particles::mass, i, {dice.between(0.5f, 2)});
    set(store, particles::contacts, i, {static_cast<float>(dice.below(7))});
  }
  return store;
}

std::vector<std::uint32_t> indices_where(const Store& store, const std::vector<std::uint8_t>& chosen) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < store.size(); ++i) {
    if (chosen[i] != 0) found.push_back(i);
  }
  return found;
}

Ghosts ghosts_of(const Action& action, const Store& store, const std::vector<std::uint32_t>& chosen) {
  Ghosts ghosts;
  for (const std::uint32_t i : chosen) ghosts.ids.push_back(store.ids()[i]);
  for (const interactions::Component c : interactions::read_by(action)) {
    ghosts.columns.emplace_back();
    for (const std::uint32_t i : chosen) ghosts.columns.back().push_back(value(store, c.attribute, i, c.component));
  }
  return ghosts;
}

// Runs a meeting on ranks that own slabs, and know only those of others' particles that lie within the action's range.
particles::Digest met_on_slabs(const Action& action, const Store& all, const std::vector<float>& cuts) {
  particles::Digest sum;
  constexpr double kInf = std::numeric_limits<double>::infinity();
  Store whole(kSchema);
  whole.append(all, indices_where(all, std::vector<std::uint8_t>(all.size(), 1)));
  const Met everything(action, 2, whole);
  const auto known = interactions::begin(everything.meeting);
  Agreement agreed = known->own();
  for (const float cut : cuts)
    agreed.extent.rounding = std::max(agreed.extent.rounding, interactions::rounding_at(std::abs(cut)));
  const double range = known->range(agreed);
  for (std::size_t d = 0; d <= cuts.size(); ++d) {
    const double low = d == 0 ? -kInf : double{cuts[d - 1]};
    const double high = d == cuts.size() ? kInf : double{cuts[d]};
    std::vector<std::uint8_t> own(all.size(), 0);
    std::vector<std::uint8_t> copied(all.size(), 0);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto x = double{value(all, particles::position, i)};
      own[i] = x >= low && x < high ? 1 : 0;
      copied[i] = own[i] == 0 && x >= low - range && x <= high + range ? 1 : 0;
    }
    Store here(kSchema);
    here.append(all, indices_where(all, own));
    const Ghosts ghosts = ghosts_of(action, all, indices_where(all, copied));
    Met met(action, 2, here);  // particles remember earlier contacts
    met.meeting.sides[0].ghosts = &ghosts;
    interactions::begin(met.meeting)->act(agreed);
    sum += particles::digest(here);
  }
  return sum;
}

}  // namespace

TEST(balls_head_on_exchange_their_velocities) {
  const std::vector<float> after = speeds_after({0.1, 1}, {{-0.25f, 1}, {0.25f, -2}});
  CHECK_NEAR(double{after[0]}, -2, 1e-5);
  CHECK_NEAR(double{after[1]}, 1, 1e-5);
  const std::vector<float> one_rests = speeds_after({0.1, 1}, {{-0.25f, 3}, {0.125f, 0}});
  CHECK_NEAR(double{one_rests[0]}, 0, 1e-5);
  CHECK_NEAR(double{one_rests[1]}, 3, 1e-5);
}

TEST(balls_that_do_not_rebound_go_on_together) {
  const std::vector<float> after = speeds_after({0.1, 0}, {{-0.25f, 2}, {0.25f, -2}});
  for (const float speed : after) CHECK_NEAR(double{speed}, 0, 1e-5);
  const std::vector<float> half = speeds_after({0.1, 0.5}, {{-0.25f, 2}, {0.25f, -2}});
  CHECK_NEAR(double{half[0]}, -1, 1e-5);
  CHECK_NEAR(double{half[1]}, 1, 1e-5);
}

TEST(heavy_and_large_balls_push_like_their_masses) {
  for (const double restitution : {0.0, 0.5, 1.0}) {  // radius: half of size
    const std::vector<Ball> before{{-0.3f, 1, 3, 0.3f}, {0.3f, -2, 0.5f, 0.1f}};
    const std::vector<float> after = speeds_after({0, restitution}, before);
    const double both = (3.0 * 1 - 0.5 * 2) / 3.5;
    CHECK_NEAR(double{after[0]}, both - restitution * 0.5 / 3.5 * 3, 1e-5);
    CHECK_NEAR(double{after[1]}, both + restitution * 3 / 3.5 * 3, 1e-5);
  }
}

TEST(balls_of_two_systems_meet_each_other_alone) {
  Collision collision{0.1, 1};
  collision.other_radius = 0.2;
  collision.two = true;
  Store first = balls({{-0.17f, 1}, {-0.2f, 1}});  // these overlap
  Store second = balls({{0.15f, -1}});
  set(first, particles::position, 1, {-0.2f, 5, 0});
  set(first, particles::position, 0, {-0.17f, 0.5f, -0.25f});
  for (int step = 0; step < 10; ++step) {
    meet(collision.action(), first, &second);
    move(first);
    move(second);
  }
  CHECK_NEAR(double{value(first, particles::velocity, 0)}, -1, 1e-5);
  CHECK_NEAR(double{value(second, particles::velocity, 0)}, 1, 1e-5);
  CHECK(value(first, particles::velocity, 1) == 1);
  Store apart = balls({{0, 1}, {0.05f, -1}});
  Store nobody = balls({});
  meet(collision.action(), apart, &nobody);
  CHECK(value(apart, particles::velocity, 0) == 1 && value(apart, particles::velocity, 1) == -1);
}

TEST(a_pair_falls_asleep_only_in_company) {
  Collision collision{0.1};
  collision.sleep = 0.5;
  Store two = balls({{0, 0.1f}, {0.2f, 0.1f}});
  set(two, particles::position, 1, {0.19995f, 0.5f, -0.25f});
  meet(collision.action(), two);
  CHECK(value(two, particles::contacts, 0) == 1 && value(two, particles::velocity, 0) != 0);
  Store three = balls({{0, 0.1f}, {0.19995f, 0.1f}, {0.3999f, 0.1f}});
  meet(collision.action(), three);
  CHECK(value(three, particles::contacts, 1) == 2 && value(three, particles::velocity, 1) == 0);
  CHECK(value(three, particles::velocity, 0) != 0 && value(three, particles::velocity, 2) != 0);
}

TEST(those_that_are_not_chosen_are_seen_but_not_changed) {
  Dice dice(1);
  const Store all = random_store(800, dice);
  for (const Action& action :
       {Collision{0, 0.5, 0.5}.action(), gravitation(0.2), matching(0.2), spin_matching(0.2), contact(), fluid()}) {
    Store changed(kSchema);
    changed.append(all, indices_where(all, std::vector<std::uint8_t>(all.size(), 1)));
    Store some(kSchema);
    some.append(all, indices_where(all, std::vector<std::uint8_t>(all.size(), 1)));
    std::vector<std::uint8_t> chosen(all.size(), 0);
    for (std::uint8_t& one : chosen) one = dice.coin() ? 1 : 0;
    const interactions::InteractionCounts seen = meet(action, changed);
    CHECK(meet(action, some, nullptr, &chosen).pairs == seen.pairs);
    CHECK(seen.pairs > 500);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Store& like = chosen[i] != 0 ? changed : all;
      for (const int attribute : {particles::velocity, particles::rotational_velocity, particles::contacts}) {
        for (int c = 0; c < kSchema[attribute].width; ++c)
          CHECK(value(some, attribute, i, c) == value(like, attribute, i, c));
      }
    }
  }
}

// Velocities of 9 m/s carry particles over a third of their radius in the step.
TEST(copies_within_the_range_are_all_that_a_rank_must_know) {
  Dice dice(2);
  Store all = random_store(1000, dice);
  meet(contact(), all);  // from now on they remember contacts
  for (const Action& action : {Collision{0, 0.5, 0.5}.action(), Collision{0.1, 0, 0.5}.action(), gravitation(0.2),
                               matching(0.2), spin_matching(0.2), gravitation(0.5), contact(), fluid()}) {
    const particles::Digest whole = met_on_slabs(action, all, {});
    CHECK(!(whole == particles::digest(all)));
    for (int round = 0; round < 8; ++round) {
      std::vector<float> cuts;
      for (std::size_t k = 0; k < 1 + dice.below(5); ++k) cuts.push_back(dice.between(-1, 1));
      if (round == 0) cuts = {0, 0.01f, 0.02f, 0.02f, 0.05f};  // thinner than the reach; one is empty
      std::sort(cuts.begin(), cuts.end());
      CHECK(met_on_slabs(action, all, cuts) == whole);
    }
  }
}

TEST(uniform_masses_and_sizes_do_as_planes_of_the_same_values) {
  Dice dice(3);
  const Store all = random_store(300, dice);
  const auto made = [&](bool uniform) {
    Store store(kSchema);
    if (uniform) {
      store.set_uniform(particles::mass, {2});
      store.set_uniform(particles::size, {0.15f, 0.15f, 0.15f});
    }
    store.grow(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      store.set_id(i, all.ids()[i]);
      for (const int attribute : {particles::position, particles::velocity}) {
        set(store, attribute, i,
            {value(all, attribute, i, 0), value(all, attribute, i, 1), value(all, attribute, i, 2)});
      }
      if (uniform) continue;
      set(store, particles::mass, i, {2});
      set(store, particles::size, i, {0.15f, 0.15f, 0.15f});
    }
    meet(Collision{0, 0.25, 0.5}.action(), store);
    return particles::digest(store);
  };
  CHECK(made(true) == made(false));
}

TEST(a_cloud_that_falls_together_keeps_its_momentum) {
  Dice dice(4);
  Store store = random_store(300, dice);
  for (std::size_t i = 0; i < store.size(); ++i) {
    set(store, particles::contacts, i, {0});
    for (int c = 0; c < 3; ++c)
      store.writable_plane(particles::velocity, c)[i] = -value(store, particles::position, i, c);
  }
  const auto momentum = [&](int c) {
    double sum = 0;
    for (std::size_t i = 0; i < store.size(); ++i)
      sum += double{value(store, particles::mass, i)} * double{value(store, particles::velocity, i, c)};
    return sum;
  };
  const double before[3] = {momentum(0), momentum(1), momentum(2)};
  std::uint64_t pairs = 0;
  for (int step = 0; step < 1000; ++step) {
    pairs += meet(Collision{0, 0.3, 0.5}.action(), store).pairs;
    move(store);
  }
  CHECK(pairs > 5000);
  for (int c = 0; c < 3; ++c) CHECK_NEAR(momentum(c), before[c], 1e-4);
}

}  // namespace motes::test_meetings_of_stores
