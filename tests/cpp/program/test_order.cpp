// Drawing order: by distance along the look direction, then by id; the others stay; NaN comes last.
#include <cmath>
#include <vector>

#include "program/order.h"
#include "support/check.h"

namespace motes::test_order {
namespace {

const particles::Schema kSchema;

// Particles 0.. at these heights, with descending ids; their mass tells them apart.
particles::Store tower(const std::vector<float>& heights) {
  particles::Store store(kSchema);
  store.grow(heights.size());
  for (int c = 0; c < 3; ++c) {
    float* x = store.writable_plane(particles::position, c);
    for (std::size_t i = 0; i < heights.size(); ++i) x[i] = c == 1 ? heights[i] : 0;
  }
  float* mass = store.writable_plane(particles::mass, 0);
  for (std::size_t i = 0; i < heights.size(); ++i) {
    store.set_id(i, 100 - i);
    mass[i] = static_cast<float>(i);
  }
  return store;
}

std::vector<int> after(const std::vector<float>& heights, const actions::Action& sort) {
  particles::Store store = tower(heights);
  program::order(sort, 0, store);
  std::vector<int> found;
  for (std::size_t i = 0; i < store.size(); ++i) {
    const auto which = static_cast<std::size_t>(store.plane(particles::mass, 0)[i]);
    CHECK(store.ids()[i] == 100 - which);
    CHECK(store.plane(particles::position, 1)[i] == heights[which] || std::isnan(heights[which]));
    found.push_back(static_cast<int>(which));
  }
  return found;
}

const actions::Action kUp = actions::make(actions::numbers::sort<>{.look = {0, 2, 0}});

}  // namespace

TEST(order_is_far_first_then_by_id) {
  CHECK((after({1, 3, 2, 3, -5}, kUp) == std::vector<int>{3, 1, 2, 0, 4}));
  const actions::Action down = actions::make(actions::numbers::sort<>{.eye = {0, 9, 0}, .look = {0, -1, 0}});
  CHECK((after({1, 3, 2, 3, -5}, down) == std::vector<int>{4, 0, 2, 3, 1}));
  CHECK(after({}, kUp).empty());
}

TEST(order_puts_last_what_is_no_number) {
  const float nan = std::nanf("");
  CHECK((after({nan, 1, nan, HUGE_VALF, -HUGE_VALF}, kUp) == std::vector<int>{3, 1, 4, 2, 0}));
}

TEST(order_leaves_the_others_in_their_places) {
  using actions::Op;
  actions::Action high = kUp;
  high.where = {{Op::constant, 0, 0}, {Op::column, 1, 0}, {Op::less, 0, 0}};  // 0 < y
  CHECK((after({1, -1, 3, -2, 2}, high) == std::vector<int>{2, 1, 4, 3, 0}));
}

}  // namespace motes::test_order
