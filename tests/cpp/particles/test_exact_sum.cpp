// Exact sums compared with integers of 128 bits, with each other in any order and parts, and at the ends of float32.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "particles/exact_sum.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_exact_sum {
using particles::ExactSum;
using particles::FloatTable;

namespace {

__extension__ using Wide = __int128;

constexpr float kLargest = std::numeric_limits<float>::max();
constexpr float kSmallest = std::numeric_limits<float>::denorm_min();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

ExactSum sum_of(const std::vector<float>& values) {
  ExactSum sum;
  for (const float value : values) sum.add(value);
  return sum;
}

ExactSum by_table(const std::vector<float>& values) {
  FloatTable table;
  table.add(values);
  ExactSum sum;
  table.add_to(sum);
  return sum;
}

void shuffle(std::vector<float>& values, test::Dice& dice) {
  for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[dice.below(i)]);
}

// Returns a random finite float32; all exponents are equally likely.
float any_float(test::Dice& dice) {
  for (;;) {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(dice.word()));
    if (std::isfinite(value)) return value;
  }
}

std::vector<float> many(std::size_t count, test::Dice& dice) {
  std::vector<float> values(count);
  for (float& value : values) value = any_float(dice);
  return values;
}

}  // namespace

TEST(exact_sums_round_as_integers_of_128_bits_do) {
  test::Dice dice(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const int unit = static_cast<int>(dice.below(160)) - 149;  // the exponent of the lowest bit
    const std::size_t span = 1 + dice.below(85);
    Wide expected = 0;
    std::vector<float> values;
    for (std::size_t i = 0, n = 1 + dice.below(60); i < n; ++i) {
      const auto mantissa = static_cast<std::int64_t>(dice.word() >> 40);
      const int shift = std::min(static_cast<int>(dice.below(span)), 104 - unit);
      const float value = std::ldexp(static_cast<float>(mantissa), unit + shift);
      const bool negative = dice.coin();
      values.push_back(negative ? -value : value);
      expected += (negative ? -1 : 1) * (static_cast<Wide>(mantissa) << shift);
    }
    const double wanted = std::ldexp(static_cast<double>(expected), unit);
    CHECK(sum_of(values).rounded() == wanted);
    CHECK(by_table(values).rounded() == wanted);
  }
}

TEST(exact_sums_are_the_same_in_any_order_and_any_parts) {
  test::Dice dice(2);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<float> values = many(1 + dice.below(300), dice);
    const ExactSum all = sum_of(values);
    shuffle(values, dice);
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(dice.below(values.size() + 1));
    ExactSum parts = by_table({values.begin(), middle});
    parts += sum_of({middle, values.end()});
    CHECK(parts == all);
    CHECK(by_table(values) == all);
  }
}

TEST(exact_sums_keep_what_is_left_when_all_else_cancels) {
  test::Dice dice(3);
  CHECK(sum_of({1e30f, 1, -1e30f}).rounded() == 1);
  CHECK(sum_of({kLargest, kSmallest, -kLargest}).rounded() == kSmallest);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<float> values = many(100, dice);
    for (std::size_t i = 0; i < 100; ++i) values.push_back(-values[i]);
    shuffle(values, dice);
    CHECK(sum_of(values).zero() && by_table(values).zero());
    const float left = any_float(dice);
    values.insert(values.begin() + static_cast<std::ptrdiff_t>(dice.below(values.size())), left);
    CHECK(sum_of(values).rounded() == left);
  }
}

TEST(exact_sums_round_to_the_nearest_double_and_ties_to_the_even_one) {
  const float half = 0x1p-53f;  // of the last bit of 1
  for (const float sign : {1.0f, -1.0f}) {
    const auto rounded = [&](std::vector<float> values) {
      for (float& value : values) value *= sign;
      return sign * sum_of(values).rounded();
    };
    CHECK(rounded({1, half}) == 1);
    CHECK(rounded({1, half, kSmallest}) == 1 + 0x1p-52);
    CHECK(rounded({1, half, -kSmallest}) == 1);
    CHECK(rounded({1, half, half}) == 1 + 0x1p-52);
    CHECK(rounded({1, half, half, half}) == 1 + 0x1p-51);
    CHECK(rounded({1, half, half, half, -kSmallest}) == 1 + 0x1p-52);
    CHECK(rounded({2, -half}) == 2);  // all bits are 1: one more bit
    CHECK(rounded({2, -half, -half, -half}) == 2 - 0x1p-51);
    CHECK(rounded({0x1p64f, 0x1p11f}) == 0x1p64);  // the half is the highest bit of a limb, or the lowest
    CHECK(rounded({0x1p64f, 0x1p11f, kSmallest}) == 0x1p64 + 0x1p12);
  }
}

TEST(exact_sums_hold_the_ends_of_float32_2_to_the_64_times) {
  for (const float value : {kLargest, -kLargest, kSmallest, -kSmallest}) {
    ExactSum sum;
    sum.add(value);
    for (int doubled = 0; doubled < 64; ++doubled) {
      const ExactSum same = sum;
      sum += same;
    }
    CHECK(sum.rounded() == std::ldexp(static_cast<double>(value), 64));
    for (int i = 0; i < 3; ++i) sum.add(-value);
    CHECK(sum.rounded() == std::ldexp(static_cast<double>(value), 64));
  }
  CHECK(std::bit_cast<std::uint64_t>(sum_of({-0.0f, -0.0f}).rounded()) == 0);
  CHECK(ExactSum().zero() && ExactSum().rounded() == 0);
}

TEST(what_is_not_finite_stays_in_an_exact_sum_wherever_it_came) {
  test::Dice dice(4);
  const auto is = [](double found, double wanted) {
    return found == wanted || (std::isnan(found) && std::isnan(wanted));
  };
  struct Case {
    std::vector<float> specials;
    float sum;
  };
  for (const Case& c : {Case{{kInfinity, kInfinity}, kInfinity}, Case{{-kInfinity}, -kInfinity},
                        Case{{kInfinity, -kInfinity}, kNan}, Case{{kNan}, kNan}, Case{{-kNan, kInfinity}, kNan}}) {
    for (int trial = 0; trial < 20; ++trial) {
      std::vector<float> values = many(20, dice);
      values.insert(values.end(), c.specials.begin(), c.specials.end());
      shuffle(values, dice);
      const auto middle = values.begin() + static_cast<std::ptrdiff_t>(dice.below(values.size() + 1));
      ExactSum parts = sum_of({values.begin(), middle});
      parts += by_table({middle, values.end()});
      CHECK(is(parts.rounded(), c.sum) && is(sum_of(values).rounded(), c.sum));
      CHECK(parts == sum_of(values) && !parts.zero());
    }
  }
}

}  // namespace motes::test_exact_sum
