// Wrapping in periodic space: where positions come to lie, and how their crossings are counted.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "particles/wrap.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_wrap {
namespace {

using namespace particles;

constexpr float kInf = std::numeric_limits<float>::infinity();

TEST(wrap_leaves_what_is_inside_and_the_low_end) {
  const Period period{-2, 3};
  for (const float x : {-2.0f, 0.0f, std::nextafter(3.0f, 0.0f), 1e-40f}) {
    CHECK(period.wrapped(x).at == x);
    CHECK(period.wrapped(x).crossed == 0);
  }
  const Wrapped zero = Period{0, 1}.wrapped(-0.0f);
  CHECK(zero.at == 0 && std::signbit(zero.at) && zero.crossed == 0);
}

TEST(wrap_counts_crossings_at_both_ends) {
  const Period period{-2, 3};
  CHECK(period.wrapped(3).at == -2 && period.wrapped(3).crossed == 1);
  CHECK(period.wrapped(4.5f).at == -0.5f && period.wrapped(4.5f).crossed == 1);
  CHECK(period.wrapped(-2.5f).at == 2.5f && period.wrapped(-2.5f).crossed == -1);
  CHECK(period.wrapped(-7).at == -2 && period.wrapped(-7).crossed == -1);
  CHECK(period.wrapped(1003).at == -2 && period.wrapped(1003).crossed == 201);
}

// The float32 below the low end would round up to the high end, which belongs to the next period.
TEST(wrap_never_returns_the_high_end) {
  const Period period{0, 10};
  const Wrapped below = period.wrapped(-1e-30f);
  CHECK(below.at == 0 && below.crossed == 0);
  const Wrapped denormal = period.wrapped(-std::numeric_limits<float>::denorm_min());
  CHECK(denormal.at == 0 && denormal.crossed == 0);
  CHECK(Period({1000, 1001}).wrapped(std::nextafter(1000.0f, 0.0f)).at < 1001);
}

TEST(wrap_keeps_far_positions_inside_whatever_is_left_of_them) {
  test::Dice dice(7);
  for (int turn = 0; turn < 20000; ++turn) {
    const float low = dice.between(-1000, 1000);
    const Period period{low, low + std::exp(dice.between(-5, 7))};
    if (!(period.low < period.high)) continue;
    const float x = dice.between(-1, 1) * std::exp(dice.between(-30, 78));
    const Wrapped wrapped = period.wrapped(x);
    CHECK(period.holds(wrapped.at));
    const double back = static_cast<double>(wrapped.at) + static_cast<double>(wrapped.crossed) * period.length();
    const double farthest = std::max({std::abs(static_cast<double>(x)), std::abs(static_cast<double>(period.low)),
                                      std::abs(static_cast<double>(period.high))});
    CHECK(std::abs(back - static_cast<double>(x)) <= farthest * 0x1p-22);
    CHECK(period.wrapped(wrapped.at).at == wrapped.at);
  }
  const float most = std::numeric_limits<float>::max();
  CHECK(Period({0, 1}).holds(Period({0, 1}).wrapped(most).at));
  CHECK(Period({0, 1}).holds(Period({0, 1}).wrapped(-most).at));
  CHECK(Period({0, 1e-3f}).wrapped(most).crossed == 1e37f && Period({0, 1e-3f}).wrapped(-most).crossed == -1e37f);
}

TEST(wrap_leaves_what_is_not_finite) {
  const Period period{0, 10};
  CHECK(period.wrapped(kInf).at == kInf && period.wrapped(kInf).crossed == 0);
  CHECK(period.wrapped(-kInf).at == -kInf);
  CHECK(std::isnan(period.wrapped(std::nanf("")).at));
}

TEST(wrap_of_a_store_counts_along_each_periodic_axis) {
  Schema schema;
  schema.add(kCrossings, 3, {});
  schema.set_periods({5, {Period{0, 10}, Period{}, Period{0, 5}}});  // x and z
  Store store(schema);
  store.grow(1000);
  for (int c = 0; c < 3; ++c) {
    float* x = store.writable_plane(position, c);
    for (std::size_t i = 0; i < 1000; ++i) x[i] = static_cast<float>(i) * 0.25f - 100;
  }
  particles::wrap(store);
  for (std::size_t i = 0; i < 1000; ++i) {
    const float x = static_cast<float>(i) * 0.25f - 100;
    CHECK(store.value(position, 1, i) == x);
    CHECK(store.value(schema.crossings(), 1, i) == 0);
    CHECK(store.value(position, 0, i) + 10 * store.value(schema.crossings(), 0, i) == x);
    CHECK(store.value(position, 2, i) + 5 * store.value(schema.crossings(), 2, i) == x);
    CHECK(store.value(position, 2, i) >= 0 && store.value(position, 2, i) < 5);
  }
}

TEST(wrap_needs_an_interval_and_an_attribute) {
  Schema schema;
  CHECK_THROWS(schema.set_periods({1, {Period{0, 10}}}), std::invalid_argument);
  schema.add(kCrossings, 3, {});
  CHECK_THROWS(schema.set_periods({1, {Period{10, 10}}}), std::invalid_argument);
  CHECK_THROWS(schema.set_periods({1, {Period{0, kInf}}}), std::invalid_argument);
  schema.set_periods({});
  CHECK(schema.crossings() == -1 && !schema.periods().any());
  schema.set_periods({1, {Period{0, 10}}});
  CHECK(schema.crossings() == builtin_count);
}

}  // namespace
}  // namespace motes::test_wrap
