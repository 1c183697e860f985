// Histories of births: what they remember, what they forget, and that they stay small.
#include <cstdint>
#include <numeric>
#include <vector>

#include "engine/state/birth_history.h"
#include "engine/state/system.h"
#include "support/check.h"

namespace motes::test_birth_history {
using engine::BirthHistory;
using recording::Birth;
using recording::Emit;
using recording::Source;

namespace {

constexpr float kDt = 1.0f / 24;

Source source(float x) {
  Source source;
  source.shape = {shapes::Kind::box, {x, 0, 0, x + 1, 1, 1}};
  source.rate = 240;
  return source;
}

Emit emitted(std::size_t rows, float x) { return {rows, {{particles::position, std::vector<float>(3 * rows, x)}}, {}}; }

// Creates the particles of one call, with copies kept from birth on.
particles::Store with_copies(const Birth& birth, const particles::Schema& schema, particles::Key key,
                             std::uint64_t first, std::uint64_t count) {
  return recording::make(birth, schema, key, first, count, kDt, true);
}

}  // namespace

TEST(a_source_that_says_the_same_in_each_frame_is_one_range) {
  BirthHistory history;
  history.add(source(0), 0, 10, kDt);
  const std::size_t bytes = history.bytes();
  for (std::uint64_t frame = 1; frame < 10000; ++frame) history.add(source(0), 10 * frame, 10, kDt);
  CHECK(history.size() == 1 && history.bytes() == bytes);
}

TEST(sources_that_take_turns_share_their_calls) {
  BirthHistory history;
  for (std::uint64_t k = 0; k < 1000; ++k) history.add(source(static_cast<float>(k % 4)), 10 * k, 10, kDt);
  CHECK(history.size() == 1000);
  CHECK(history.bytes() < 4 * 1000 + 1000 * 24);
}

TEST(what_is_dead_on_all_ranks_is_forgotten) {
  constexpr std::size_t kLimit = std::size_t{64} << 20;
  BirthHistory history;
  history.add(emitted(1000, 0), 0, 1000, kDt);
  CHECK(!history.wants_pruning(kLimit) && history.wants_pruning(2 * history.bytes()));
  for (std::uint64_t k = 1; k < 100; ++k) history.add(emitted(1000, static_cast<float>(k)), 1000 * k, 1000, kDt);
  const std::size_t all = history.bytes();
  CHECK(history.wants_pruning(kLimit));  // long before that: a run of 10,000 frames should not grow
  history.forget_before(90500);
  CHECK(history.size() == 10 && history.bytes() < all / 9);
  CHECK(!history.wants_pruning(0));  // not again before it has doubled
  for (std::uint64_t k = 100; k < 111; ++k) history.add(emitted(1000, static_cast<float>(k)), 1000 * k, 1000, kDt);
  CHECK(history.wants_pruning(0));
}

TEST(birth_values_come_back_for_the_living_whatever_was_forgotten) {
  const particles::Schema schema;
  const particles::Key key = particles::system_key(7, 0);
  BirthHistory history;
  history.add(source(5), 0, 100, kDt);
  history.add(emitted(50, 3), 100, 50, kDt);
  history.add(source(-5), 150, 100, kDt);
  history.forget_before(120);
  particles::Store living(schema);  // ids 120 .. 249, at their current positions
  living.reserve(130);
  living.grow(130);
  for (std::size_t i = 0; i < 130; ++i) living.set_id(i, 120 + i);
  for (int c = 0; c < 3; ++c) std::fill_n(living.writable_plane(particles::position, c), 130, 99.0f);
  history.restore_copies(living, key);
  const particles::Store late = with_copies(source(-5), schema, key, 150, 100);
  for (std::size_t i = 0; i < 130; ++i) {
    const float x = living.plane(particles::position_b, 0)[i];
    CHECK(x == (i < 30 ? 3.0f : late.plane(particles::position_b, 0)[i - 30]));
  }
  CHECK(history.size() == 0);
}

TEST(birth_values_come_back_behind_ids_that_another_history_has) {
  const particles::Schema schema;
  const particles::Key key = particles::system_key(7, 0);
  BirthHistory history;
  history.add(source(5), 0, 10, kDt);
  history.add(source(5), 15, 10, kDt);
  particles::Store living(schema);  // ids 0 .. 9 and 15 .. 24
  living.reserve(20);
  living.grow(20);
  for (std::size_t i = 0; i < 20; ++i) living.set_id(i, i < 10 ? i : i + 5);
  for (int c = 0; c < 3; ++c) std::fill_n(living.writable_plane(particles::position, c), 20, 99.0f);
  history.restore_copies(living, key);
  const particles::Store early = with_copies(source(5), schema, key, 0, 10);
  const particles::Store late = with_copies(source(5), schema, key, 15, 10);
  for (std::size_t i = 0; i < 20; ++i) {
    const particles::Store& born = i < 10 ? early : late;
    CHECK(living.plane(particles::position_b, 0)[i] == born.plane(particles::position_b, 0)[i % 10]);
  }
}

}  // namespace motes::test_birth_history
