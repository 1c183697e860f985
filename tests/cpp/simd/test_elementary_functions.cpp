// Elementary functions of any argument compared with long double: errors in ulp, special values, equal bits in every
// build.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <vector>

#include "support/check.h"
#include "support/functions_builds.h"

namespace motes::test_elementary_functions {
namespace {

using test::FunctionsProbe;
using Numbers = std::vector<float>;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kDenormal = 1e-42f;

// Returns numbers, half of them evenly spread, half random.
Numbers numbers(std::size_t count, float low, float high) {
  test::Dice dice(11);
  Numbers v(count);
  for (std::size_t i = 0; i < count; ++i) {
    const float even = low + (high - low) * static_cast<float>(i) / static_cast<float>(count);
    v[i] = i % 2 == 0 ? even : dice.between(low, high);
  }
  return v;
}

// Returns numbers of every magnitude in 2^low .. 2^high, with both signs if asked for.
Numbers magnitudes(std::size_t count, int low, int high, bool both_signs) {
  test::Dice dice(12);
  Numbers v(count);
  for (float& value : v) {
    const int exponent = low + static_cast<int>(dice.below(static_cast<std::size_t>(high - low)));
    value = std::ldexp(dice.between(1, 2), exponent);
    if (both_signs && dice.coin()) value = -value;
  }
  return v;
}

double ulps(float value, long double exact) {
  if (std::isinf(value) && std::fabs(exact) > 3.4028235677973366e38L) return (value > 0) == (exact > 0) ? 0 : 1e9;
  int exponent = 0;
  std::frexp(exact, &exponent);  // exact = m 2^exponent, m in [0.5, 1)
  const long double ulp = std::ldexp(1.0L, std::max(exponent - 24, -149));
  return static_cast<double>(std::fabs(value - exact) / ulp);
}

double worst_of(const Numbers& values, const std::function<long double(std::size_t)>& exact) {
  double worst = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double error = ulps(values[i], exact(i));
    if (!(error <= worst)) worst = error;  // NaN counts as worst
  }
  return worst;
}

void check_one(FunctionsProbe::One FunctionsProbe::* function, long double (*exact)(long double), const Numbers& v,
               double allowed) {
  Numbers first;
  for (const FunctionsProbe* build : test::function_builds()) {
    Numbers out(v.size());
    (build->*function)(v.data(), v.size(), out.data());
    if (first.empty()) {
      first = out;
      const double worst = worst_of(out, [&](std::size_t i) { return exact(v[i]); });
      CHECK_NEAR(worst, 0, allowed);
    }
    CHECK(std::memcmp(first.data(), out.data(), out.size() * sizeof(float)) == 0);
  }
}

void check_two(FunctionsProbe::Two FunctionsProbe::* function, long double (*exact)(long double, long double),
               const Numbers& a, const Numbers& b, double allowed) {
  Numbers first;
  for (const FunctionsProbe* build : test::function_builds()) {
    Numbers out(a.size());
    (build->*function)(a.data(), b.data(), a.size(), out.data());
    if (first.empty()) {
      first = out;
      const double worst = worst_of(out, [&](std::size_t i) { return exact(a[i], b[i]); });
      CHECK_NEAR(worst, 0, allowed);
    }
    CHECK(std::memcmp(first.data(), out.data(), out.size() * sizeof(float)) == 0);
  }
}

float one(FunctionsProbe::One FunctionsProbe::* function, float value) {
  const Numbers v(16, value);
  Numbers out(16);
  (test::function_builds().back()->*function)(v.data(), 16, out.data());
  return out[0];
}

float two(FunctionsProbe::Two FunctionsProbe::* function, float a, float b) {
  const Numbers v(16, a), w(16, b);
  Numbers out(16);
  (test::function_builds().back()->*function)(v.data(), w.data(), 16, out.data());
  return out[0];
}

// Returns whether two results agree as well as those of two good implementations of the C library: not to the last bit,
// but in sign, including the sign of zeros.
bool alike(float a, float b) {
  if (std::isnan(a) || std::isnan(b) || std::isinf(a) || std::isinf(b)) {
    return (std::isnan(a) && std::isnan(b)) || a == b;
  }
  return std::signbit(a) == std::signbit(b) && std::fabs(a - b) <= 1.2e-7f * std::fabs(b) + 2e-45f;
}

constexpr std::size_t kMany = 1 << 18;
constexpr auto kSin = &FunctionsProbe::sin;
constexpr auto kCos = &FunctionsProbe::cos;
constexpr auto kExp = &FunctionsProbe::exp;
constexpr auto kExp2 = &FunctionsProbe::exp2;
constexpr auto kLog = &FunctionsProbe::log;
constexpr auto kAsin = &FunctionsProbe::asin;
constexpr auto kAcos = &FunctionsProbe::acos;
constexpr auto kPow = &FunctionsProbe::pow;
constexpr auto kAtan2 = &FunctionsProbe::atan2;
constexpr auto kNaturalLog = &FunctionsProbe::natural_log;
constexpr auto kFloor = &FunctionsProbe::floor;
constexpr auto kPower = &FunctionsProbe::power;
constexpr auto kModulo = &FunctionsProbe::modulo;

// Returns the modulo of Python and NumPy in long double, which is exact for floats.
long double modulo(long double x, long double y) {
  const long double rest = std::fmod(x, y);
  if (rest == 0) return std::copysign(0.0L, y);
  return (rest < 0) != (y < 0) ? rest + y : rest;
}

}  // namespace

TEST(sin_and_cos_of_radians) {
  for (const float most : {0.8f, 10.0f, 1e4f, 1e6f}) {
    check_one(kSin, std::sin, numbers(kMany, -most, most), 2);
    check_one(kCos, std::cos, numbers(kMany, -most, most), 2);
  }
  // Close to multiples of pi / 2, only the error of the reduction is left.
  Numbers near(kMany);
  for (std::size_t i = 0; i < kMany; ++i) near[i] = static_cast<float>(static_cast<double>(i) * 1.5707963267948966);
  check_one(kSin, std::sin, near, 2);
  check_one(kCos, std::cos, near, 2);
  check_one(kSin, std::sin, magnitudes(kMany, -149, 0, true), 2);
  CHECK(one(kSin, 0) == 0 && one(kCos, 0) == 1 && one(kSin, kDenormal) == kDenormal);
  CHECK(std::isnan(one(kSin, kInfinity)) && std::isnan(one(kCos, -kInfinity)) && std::isnan(one(kSin, kNan)));
  CHECK_NEAR(one(kSin, 9.9e8f), std::sin(double{9.9e8f}), 3e-7);
  CHECK(one(kSin, 1e20f) == 0 && one(kCos, 1e20f) == 1);
}

TEST(exp_and_exp2) {
  check_one(kExp, std::exp, numbers(kMany, -104, 88.73f), 2);
  check_one(kExp, std::exp, numbers(kMany, -1, 1), 2);
  check_one(kExp, std::exp, magnitudes(kMany, -149, 6, true), 2);
  check_one(kExp2, std::exp2, numbers(kMany, -150, 128), 2);
  check_one(kExp2, std::exp2, numbers(kMany, -1, 1), 2);
  for (int n = -149; n < 128; ++n) CHECK(one(kExp2, static_cast<float>(n)) == std::ldexp(1.0f, n));
  for (const auto function : {kExp, kExp2}) {
    CHECK(one(function, 0) == 1 && one(function, kInfinity) == kInfinity && one(function, -kInfinity) == 0);
    CHECK(one(function, 3e38f) == kInfinity && one(function, -3e38f) == 0 && std::isnan(one(function, kNan)));
    CHECK(one(function, kDenormal) == 1);
  }
}

TEST(log_of_normal_numbers_in_ulp) {
  check_one(kLog, std::log, numbers(kMany, 0.4f, 2.5f), 2);
  check_one(kLog, std::log, magnitudes(kMany, -126, 127, false), 2);
  CHECK(one(kLog, 1) == 0);
}

TEST(pow_of_numbers_above_zero) {
  const Numbers x = magnitudes(kMany, -149, 127, false);
  check_two(kPow, std::pow, x, numbers(kMany, -4, 4), 1);
  check_two(kPow, std::pow, numbers(kMany, 0, 2), numbers(kMany, -200, 200), 1);
  check_two(kPow, std::pow, numbers(kMany, 0.99f, 1.01f), magnitudes(kMany, -10, 14, true), 1);
  check_two(kPow, std::pow, x, Numbers(kMany, 0.5f), 1);
  const Numbers special = {0, -0.0f, kDenormal, 0.5f, 1, 2, 1e30f, kInfinity, kNan};
  for (const float a : special) {
    for (const float b : special) {
      for (const float exponent : {b, -b}) {
        CHECK(alike(two(kPow, std::fabs(a), exponent), std::pow(std::fabs(a), exponent)));
      }
    }
  }
  CHECK(std::isnan(two(kPow, -1, 2)) && two(kPow, -1, 0) == 1 && two(kPow, kNan, 0) == 1 && two(kPow, 1, kNan) == 1);
}

TEST(log_of_any_number) {
  check_one(kNaturalLog, std::log, magnitudes(kMany, -149, 127, false), 1);
  check_one(kNaturalLog, std::log, numbers(kMany, 0.9f, 1.1f), 1);
  CHECK(one(kNaturalLog, 1) == 0 && !std::signbit(one(kNaturalLog, 1)));
  CHECK(one(kNaturalLog, 0) == -kInfinity && one(kNaturalLog, -0.0f) == -kInfinity);
  CHECK(one(kNaturalLog, kInfinity) == kInfinity);
  for (const float wrong : {-kDenormal, -1.0f, -kInfinity, kNan}) CHECK(std::isnan(one(kNaturalLog, wrong)));
}

TEST(powers_of_any_number) {
  check_two(kPower, std::pow, magnitudes(kMany, -149, 127, false), numbers(kMany, -4, 4), 1);
  Numbers whole = numbers(kMany, -9, 9);
  for (float& v : whole) v = std::nearbyint(v);
  check_two(kPower, std::pow, numbers(kMany, -20, 20), whole, 1);
  const Numbers special = {0, kDenormal, 0.5f, 1, 2, 3, 2.5f, 16777215, 16777216, 3e38f, kInfinity, kNan};
  for (const float a : special) {
    for (const float b : special) {
      for (const float x : {a, -a}) {
        if (x == -1 && std::isinf(b)) continue;  // 1 in C; whatever the sign of the base
        for (const float y : {b, -b}) CHECK(alike(two(kPower, x, y), std::pow(x, y)));
      }
    }
  }
}

TEST(modulo_has_the_sign_of_the_divisor_and_is_exact) {
  Numbers other = magnitudes(kMany, -149, 127, true);
  std::rotate(other.begin(), other.begin() + 7, other.end());
  check_two(kModulo, modulo, magnitudes(kMany, -149, 127, true), other, 0.5);
  check_two(kModulo, modulo, numbers(kMany, -100, 100), numbers(kMany, -3, 3.001f), 0.5);
  check_two(kModulo, modulo, numbers(kMany, -1e9f, 1e9f), Numbers(kMany, 0.1f), 0.5);
  Numbers multiples = numbers(kMany, -1000, 1000);
  for (float& v : multiples) v = std::nearbyint(v) * 0.75f;
  check_two(kModulo, modulo, multiples, Numbers(kMany, 0.75f), 0);
  CHECK(std::signbit(two(kModulo, 6, -3)) && !std::signbit(two(kModulo, -6, 3)));
  CHECK(two(kModulo, 1, kInfinity) == 1 && two(kModulo, -1, kInfinity) == kInfinity);
  CHECK(two(kModulo, 1, -kInfinity) == -kInfinity && two(kModulo, 0, kInfinity) == 0);
  for (const float wrong : {kInfinity, -kInfinity, kNan}) CHECK(std::isnan(two(kModulo, wrong, 2)));
  CHECK(std::isnan(two(kModulo, 1, 0)) && std::isnan(two(kModulo, 0, 0)) && std::isnan(two(kModulo, 1, kNan)));
}

TEST(floor_of_any_number) {
  check_one(kFloor, std::floor, numbers(kMany, -1000, 1000), 0);
  check_one(kFloor, std::floor, magnitudes(kMany, -149, 127, true), 0);
  CHECK(one(kFloor, kInfinity) == kInfinity && std::isnan(one(kFloor, kNan)));
}

TEST(atan2_of_all_directions) {
  check_two(kAtan2, std::atan2, numbers(kMany, -1, 1), magnitudes(kMany, -4, 2, true), 1);
  check_two(kAtan2, std::atan2, magnitudes(kMany, -149, 127, true), numbers(kMany, -3e38f, 3e38f), 1);
  Numbers other = magnitudes(kMany, -149, 127, true);
  std::rotate(other.begin(), other.begin() + 1, other.end());
  check_two(kAtan2, std::atan2, magnitudes(kMany, -149, 127, true), other, 1);
  const Numbers special = {0, 1, 2, kDenormal, 3e38f, kInfinity, kNan};
  for (const float y : special) {
    for (const float x : special) {
      for (const float sign : {1.0f, -1.0f}) {
        CHECK(alike(two(kAtan2, y, sign * x), std::atan2(y, sign * x)));
        CHECK(alike(two(kAtan2, -y, sign * x), std::atan2(-y, sign * x)));
      }
    }
  }
}

TEST(asin_and_acos) {
  for (const auto& v : {numbers(kMany, -1, 1), numbers(kMany, 0.999f, 1), magnitudes(kMany, -149, 0, true)}) {
    check_one(kAsin, std::asin, v, 1);
    check_one(kAcos, std::acos, v, 1);
  }
  CHECK(one(kAcos, 1) == 0 && one(kAsin, 0) == 0 && one(kAsin, 1) == static_cast<float>(1.5707963267948966));
  CHECK(std::isnan(one(kAsin, 1.0000001f)) && std::isnan(one(kAcos, -2)) && std::isnan(one(kAcos, kNan)));
}

}  // namespace motes::test_elementary_functions
