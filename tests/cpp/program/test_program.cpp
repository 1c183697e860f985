// The compiled list: sub-steps, newborns, the dead and the migrants; births by number and time.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "engine/state/system.h"
#include "particles/digest.h"
#include "program/fetch_ahead.h"
#include "program/program.h"
#include "recording/births.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_program {
using namespace program;
using namespace recording;
using actions::Action;
using particles::Store;

namespace {

const particles::Schema kSchema;
constexpr particles::Key kKey{5, 6};

Store random_store(std::size_t count, std::uint64_t seed) {
  test::Dice dice(seed);
  Store store(kSchema);
  store.grow(count);
  for (std::size_t i = 0; i < count; ++i) store.set_id(i, 1000 + i);
  for (int c = 0; c < 3; ++c) {
    float* x = store.writable_plane(particles::position, c);
    float* v = store.writable_plane(particles::velocity, c);
    for (std::size_t i = 0; i < count; ++i) {
      x[i] = dice.between(-1, 1);
      v[i] = dice.between(-1, 1);
    }
  }
  return store;
}

Store copy_of(const Store& store) {
  std::vector<std::uint32_t> all(store.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
  base::Bytes bytes;
  store.pack(all, bytes);
  base::Reader in(bytes.view());
  Store copy(kSchema);
  copy.unpack(in);
  return copy;
}

shapes::Shape ball(float radius) {
  shapes::Shape s;
  s.kind = shapes::Kind::sphere;
  s.number[3] = radius;
  return s;
}

Action gravity() { return actions::make(actions::numbers::gravity<>{.acceleration = {0, -9.8, 1}}); }
Action shake() { return actions::make(actions::numbers::random_acceleration<>{}, {ball(50)}); }
Action move() { return actions::make(actions::numbers::move<>{.rotational = 1}); }
Action kill_old(double age) { return actions::make(actions::numbers::kill_old<>{.age_limit = age}); }

}  // namespace

TEST(program_substeps_are_small_steps) {
  Store store = random_store(100, 1), once = copy_of(store);
  program::ListResult outcome;
  program::Program({gravity(), move()}).run(store, 0, 0, {4, 3, 0.3, 0}, kKey, {}, outcome);
  const float dt = static_cast<float>(0.3 / 3);
  for (std::size_t i = 0; i < once.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      float x = once.plane(particles::position, c)[i];
      float v = once.plane(particles::velocity, c)[i];
      const float pull = (c == 0 ? 0.0f : c == 1 ? -9.8f : 1.0f) * dt;
      for (int step = 0; step < 3; ++step) {
        v += pull;
        x += v * dt;
      }
      CHECK(store.plane(particles::position, c)[i] == x && store.plane(particles::velocity, c)[i] == v);
    }
    CHECK(store.plane(particles::age, 0)[i] == 0.3f);
  }
  CHECK(outcome.dead.empty() && outcome.left.empty());
}

TEST(program_frames_and_substeps_have_streams_of_their_own) {
  const Store start = random_store(50, 2);
  std::vector<std::string> seen;
  for (const Span span : {Span{0, 1, 0.1, 0}, Span{1, 1, 0.1, 0}, Span{0, 2, 0.2, 1}, Span{2, 1, 0.1, 0}}) {
    Store store = copy_of(start);
    program::ListResult outcome;
    program::Program({shake()}).run(store, 0, 0, span, kKey, {}, outcome);
    seen.push_back(particles::digest(store).text());
  }
  // Frame 0 with two sub-steps: the second sub-step is step 1, as is frame 1 with one sub-step.
  CHECK(seen[1] == seen[2]);
  CHECK(seen[0] != seen[1] && seen[1] != seen[3] && seen[0] != seen[3]);
}

TEST(program_in_two_parts_is_the_program) {
  const Store start = random_store(700, 3);
  Store whole = copy_of(start), parts = copy_of(start);
  program::ListResult outcome;
  const Span span{9, 1, 0.05, 0};
  program::Program({gravity(), shake(), move(), shake()}).run(whole, 0, 0, span, kKey, {}, outcome);
  program::Program({gravity(), shake()}).run(parts, 0, 0, span, kKey, {}, outcome);
  program::Program({move(), shake()}, 2).run(parts, 0, 0, span, kKey, {}, outcome);
  CHECK(particles::digest(whole) == particles::digest(parts));
}

TEST(program_knows_neither_order_nor_blocks) {
  const Store start = random_store(1300, 4);
  const Span span{1, 2, 0.1, 0};
  const program::Program program({shake(), move(), kill_old(0.04)});
  Store whole = copy_of(start);
  program::ListResult outcome;
  program.run(whole, 0, 0, span, kKey, {}, outcome);
  CHECK(outcome.dead.size() == whole.size());
  particles::Digest sum;
  test::Dice dice(4);
  std::vector<std::vector<std::uint32_t>> indices(5);
  for (std::uint32_t i = 1300; i-- > 0;) indices[dice.below(5)].push_back(i);
  for (const auto& mine : indices) {
    base::Bytes bytes;
    start.pack(mine, bytes);
    base::Reader in(bytes.view());
    Store part(kSchema);
    part.unpack(in);
    program::ListResult own;
    program.run(part, 0, 0, span, kKey, {}, own);
    CHECK(own.dead.size() == part.size());
    sum += particles::digest(part);
  }
  CHECK(sum == particles::digest(whole));
}

TEST(program_lets_newborns_enter_behind_the_call_that_made_them) {
  Store store = random_store(600, 5);
  const Store before = copy_of(store);
  program::ListResult outcome;
  // The last 100 enter before the last action of the second of two sub-steps: a move.
  program::Program({gravity(), move()}).run(store, 500, 1, {0, 2, 0.2, 1}, kKey, {}, outcome);
  for (std::size_t i = 0; i < store.size(); ++i) {
    const float v = before.plane(particles::velocity, 1)[i];
    const float x = before.plane(particles::position, 1)[i];
    CHECK(store.plane(particles::velocity, 1)[i] == v);
    CHECK(store.plane(particles::position, 1)[i] == (i < 500 ? x : x + v * 0.1f));
  }
}

TEST(program_names_the_dead_and_those_that_leave) {
  for (const std::size_t count : {1u, 17u, 127u, 128u, 129u, 2000u}) {
    Store store = random_store(count, count);
    float* age = store.writable_plane(particles::age, 0);
    for (std::size_t i = 0; i < count; ++i) age[i] = i % 7 == 3 ? 5.0f : 0.0f;
    store.writable_plane(particles::position, 1)[0] = std::numeric_limits<float>::quiet_NaN();
    program::ListResult outcome;
    const Slice slice{1, -0.25f, 0.5f};
    program::Program({move(), kill_old(1)}).run(store, 0, 0, {0, 1, 0.1, 0}, kKey, slice, outcome);
    program::ListResult wanted;
    const float* y = store.plane(particles::position, 1);
    for (std::uint32_t i = 0; i < count; ++i) {
      if (i % 7 == 3 || i == 0) {  // the first position is NaN
        wanted.dead.push_back(i);
      } else if (!(y[i] >= -0.25f && y[i] < 0.5f)) {
        wanted.left.push_back(i);
      }
    }
    CHECK(outcome.dead == wanted.dead && outcome.left == wanted.left);
    CHECK(store.size() == count);
    program::ListResult again;
    program::Program::find_migrants(store, 0, slice, again);
    CHECK(again.left.size() >= wanted.left.size() && again.dead.empty());
  }
}

// Particles selected by a condition die, and those that were dead before the action stay dead.
TEST(program_with_conditions_kills_the_chosen_and_revives_nobody) {
  using actions::Op;
  for (const std::size_t count : {1u, 31u, 33u, 128u, 1000u}) {
    Store store = random_store(count, count);
    float* age = store.writable_plane(particles::age, 0);
    for (std::size_t i = 0; i < count; ++i) age[i] = i % 5 == 2 ? 5.0f : 0.0f;
    Action high = kill_old(0);  // all that are above 0.5
    high.where = {{Op::constant, 0, 0.5f}, {Op::column, 1, 0}, {Op::less, 0, 0}};
    program::ListResult outcome;
    program::Program({kill_old(1), high}).run(store, 0, 0, {0, 1, 0.1, 0}, kKey, {}, outcome);
    std::vector<std::uint32_t> wanted;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (i % 5 == 2 || store.plane(particles::position, 1)[i] > 0.5f) wanted.push_back(i);
    }
    CHECK(outcome.dead == wanted);
  }
}

TEST(program_brings_those_to_be_removed_to_the_front_of_each_range) {
  const Slice slice{1, -0.7f, 0.7f};
  const program::Program program({gravity(), shake(), move(), kill_old(1)});
  for (const auto& [count, threads, grain] : {std::tuple{1u, 1, 64u},
                                              {129u, 1, 64u},
                                              {5000u, 1, 64u},
                                              {5000u, 3, 64u},
                                              {5000u, 2, 1000u},
                                              {5000u, 7, 128u}}) {
    threads::Pool pool(threads, grain);
    Store before = random_store(count, count);
    float* age = before.writable_plane(particles::age, 0);
    for (std::size_t i = 0; i < count; ++i) age[i] = i % 11 == 3 ? 5.0f : 0.0f;
    Store stay = copy_of(before), come = copy_of(before);
    program::ListResult stayed, came;
    came.gathers = true;
    program.run(stay, 0, 0, {0, 2, 0.1, 0}, kKey, slice, stayed, pool);
    program.run(come, 0, 0, {0, 2, 0.1, 0}, kKey, slice, came, pool);
    CHECK(particles::digest(come) == particles::digest(stay));
    const auto ids = [](const Store& store, const std::vector<std::uint32_t>& particles) {
      std::vector<std::uint64_t> found;
      for (const std::uint32_t p : particles) found.push_back(store.ids()[p]);
      std::sort(found.begin(), found.end());
      return found;
    };
    CHECK(ids(come, came.dead) == ids(stay, stayed.dead) && ids(come, came.left) == ids(stay, stayed.left));
    CHECK(std::is_sorted(came.dead.begin(), came.dead.end()) && std::is_sorted(came.left.begin(), came.left.end()));
    std::vector<std::uint32_t> gone(came.dead);
    gone.insert(gone.end(), came.left.begin(), came.left.end());
    std::sort(gone.begin(), gone.end());
    if (threads == 1) {
      for (std::uint32_t i = 0; i < gone.size(); ++i) CHECK(gone[i] == i);
    }
    std::vector<std::uint32_t> others(stayed.dead);
    others.insert(others.end(), stayed.left.begin(), stayed.left.end());
    std::sort(others.begin(), others.end());
    come.remove(gone, pool);
    stay.remove(others, pool);
    CHECK(come.size() == stay.size() && particles::digest(come) == particles::digest(stay));
  }
}

TEST(program_of_nothing_does_nothing) {
  Store store = random_store(10, 6);
  Store empty(kSchema);
  program::ListResult outcome;
  program::Program({}).run(store, 0, 0, {0, 1, 0.1, 0}, kKey, {}, outcome);
  program::Program({gravity(), move()}).run(empty, 0, 0, {0, 1, 0.1, 0}, kKey, {}, outcome);
  CHECK(particles::digest(store) == particles::digest(random_store(10, 6)));
  CHECK(outcome.dead.empty() && outcome.left.empty());
}

TEST(births_depend_on_their_numbers_alone) {
  Source source;
  source.shape = ball(2);
  const Given velocity{particles::velocity, actions::distributions::Normal{{}, {1, 1, 1}}};
  const Given color{particles::color, actions::distributions::Value{{0.5f}}};
  source.state = {velocity, color};
  source.jitter = true;
  const Store whole = make(source, kSchema, kKey, 100, 1000, 0.1f);
  particles::Digest sum;
  for (const auto& [first, count] : {std::pair{100, 1}, {101, 511}, {612, 30}, {642, 458}}) {
    sum += particles::digest(
        make(source, kSchema, kKey, static_cast<std::uint64_t>(first), static_cast<std::uint64_t>(count), 0.1f));
  }
  CHECK(sum == particles::digest(whole));
  CHECK(whole.uniform(particles::color) && whole.uniform_value(particles::color)[0] == 0.5f);
  CHECK(make(source, kSchema, kKey, 0, 0, 0.1f).size() == 0);
}

TEST(births_are_made_by_any_numbers_in_any_order) {
  Emit emit;
  emit.count = 100;
  emit.columns = {{particles::position, std::vector<float>(300)}, {particles::mass, std::vector<float>(100)}};
  std::iota(emit.columns[0].values.begin(), emit.columns[0].values.end(), 0.0f);
  std::iota(emit.columns[1].values.begin(), emit.columns[1].values.end(), 1000.0f);
  emit.state = {{particles::color, actions::distributions::Uniform{{}, {1, 1, 1}}}};
  const Store whole = make(emit, kSchema, kKey, 7000, 100, 0.1f);
  std::vector<std::uint64_t> odd, even;  // descending
  for (std::uint64_t number = 100; number-- > 0;) (number % 2 != 0 ? odd : even).push_back(7000 + number);
  particles::Digest sum;
  for (const std::vector<std::uint64_t>& ids : {odd, even}) {
    sum += particles::digest(make(emit, kSchema, kKey, ids, 0.1f, false, 7000));
  }
  CHECK(sum == particles::digest(whole));
  CHECK(make(emit, kSchema, kKey, odd, 0.1f, false, 7000).plane(particles::mass, 0)[0] == 1099);
}

TEST(births_are_checked) {
  Source source;
  source.rate = -1;
  CHECK_THROWS(recording::check(source, kSchema), std::invalid_argument);
  source.rate = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS(recording::check(source, kSchema), std::invalid_argument);
  Emit emit;
  emit.count = 2;
  emit.columns = {{particles::position, {1, 2, 3}}};
  CHECK_THROWS(recording::check(emit, kSchema), std::invalid_argument);
  Burst given;
  given.state = {{particles::mass, actions::distributions::InShape{}}};
  CHECK_THROWS(recording::check(given, kSchema), std::invalid_argument);
}

TEST(system_counts_births_and_drops_those_above_the_capacity) {
  SystemDefinition definition;
  definition.name = "snow";
  definition.capacity = 25;
  engine::System system(definition, 1, 0, 3);
  Burst burst;
  burst.count = 10;
  Source source;
  source.rate = 100;
  system.list = {gravity(), burst, move(), source};
  system.count_births(0.1, 2);
  const std::vector<engine::BirthGroup> groups = system.groups;
  CHECK(groups.size() == 3);
  CHECK(groups[0].entry == 1 && groups[0].substep == 0 && groups[0].first_id == 0 && groups[0].count == 10);
  CHECK(groups[1].entry == 2 && groups[1].substep == 0 && groups[1].first_id == 10 && groups[1].count == 5);
  CHECK(groups[2].entry == 2 && groups[2].substep == 1 && groups[2].first_id == 15 && groups[2].count == 5);
  system.mark_run();
  system.count_births(0.1, 2);
  CHECK(!system.pending() && system.groups.empty());
  system.list.emplace_back(burst);
  system.count_births(0.1, 2);
  CHECK(system.groups.front().count == 5 && system.counts.dropped == 5 && system.counts.born == 25);
}

TEST(program_gives_the_same_on_any_number_of_threads) {
  const Store before = random_store(200003, 9);
  const Slice slice{0, -0.9f, 0.9f};
  const Span span{3, 2, 0.1, 0};
  const program::Program program({gravity(), shake(), move(), kill_old(0.15)});
  std::vector<program::ListResult> outcomes;
  std::vector<particles::Digest> digests;
  for (const int threads : {1, 2, 3, 7}) {
    threads::Pool pool(threads);
    int pauses = 0;
    pool.meanwhile([&] { ++pauses; });
    Store store = copy_of(before);
    float* age = store.writable_plane(particles::age, 0);
    for (std::size_t i = 0; i < store.size(); ++i) age[i] = static_cast<float>(i % 100) * 0.001f;
    program::ListResult outcome;
    program.run(store, 77, 1, span, kKey, slice, outcome, pool);
    CHECK(threads > 1 || pauses > 1);  // a long run must not delay messages
    digests.push_back(particles::digest(store));
    program::ListResult found;
    program::Program::find_migrants(store, 5, slice, found, pool);
    CHECK(std::is_sorted(found.left.begin(), found.left.end()) && found.left.size() > outcome.left.size());
    outcomes.push_back(outcome);
  }
  CHECK(!outcomes[0].dead.empty() && !outcomes[0].left.empty());
  for (std::size_t i = 1; i < outcomes.size(); ++i) {
    CHECK(digests[i] == digests[0]);
    CHECK(outcomes[i].dead == outcomes[0].dead && outcomes[i].left == outcomes[0].left);
  }
}

TEST(the_next_block_is_asked_for_by_the_time_that_the_last_action_has_run) {
  const Store store = random_store(2000, 5);
  constexpr std::uint64_t attributes = 1u << particles::position | 1u << particles::velocity | 1u << particles::age;
  for (const std::size_t block : {particles::kShortBlock, particles::kBlock}) {
    const std::size_t lines = (6 + 1) * 4 * block / 64;  // age has no plane
    for (const std::size_t runs : {1u, 4u, 5u, 12u, 100u}) {
      program::FetchAhead ahead(store, attributes, true, runs, block);
      CHECK(ahead.left() == 0);
      for (const std::size_t next : {block, 7 * block}) {
        ahead.aim(next, store.size());
        CHECK(ahead.left() == lines);
        for (std::size_t run = 0; run < runs; ++run) {
          CHECK(ahead.left() * runs <= lines * (runs - run));
          ahead.fetch();
        }
        CHECK(ahead.left() == 0);
      }
      ahead.aim(16 * block, store.size());
      CHECK(ahead.left() == 0);
    }
  }
  program::FetchAhead none(store, attributes, true, 4, 0);
  none.aim(particles::kBlock, store.size());
  none.fetch();
  CHECK(none.left() == 0);
}

// Long lists may run in longer blocks.
TEST(program_of_many_actions_does_to_a_particle_what_it_does_to_it_alone) {
  const Store start = random_store(600, 17);
  std::vector<Action> list;
  for (int k = 0; k < 4; ++k) list.insert(list.end(), {gravity(), shake(), move()});
  list.push_back(kill_old(0.15));
  const program::Program program(list);
  const Span span{9, 2, 0.05, 0};
  Store whole = copy_of(start);
  program::ListResult outcome;
  program.run(whole, 0, 0, span, kKey, {}, outcome);
  CHECK(outcome.dead.size() == whole.size());  // their age has advanced by 0.2 s
  for (std::size_t i = 0; i < start.size(); i += 7) {
    Store one(kSchema);
    one.grow(1);
    one.set_id(0, 1000 + i);
    for (int c = 0; c < 3; ++c) {
      *one.writable_plane(particles::position, c) = start.plane(particles::position, c)[i];
      *one.writable_plane(particles::velocity, c) = start.plane(particles::velocity, c)[i];
    }
    program::ListResult own;
    program.run(one, 0, 0, span, kKey, {}, own);
    for (int c = 0; c < 3; ++c) {
      CHECK(*one.plane(particles::position, c) == whole.plane(particles::position, c)[i]);
      CHECK(*one.plane(particles::velocity, c) == whole.plane(particles::velocity, c)[i]);
    }
  }
}

}  // namespace motes::test_program
