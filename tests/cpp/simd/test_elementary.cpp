// The engine's own elementary functions compared with long double.
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "support/check.h"
#include "support/isas.h"

namespace motes::test_elementary {
namespace {

constexpr long double kTurn = 6.283185307179586476925286766559005768L;

struct Worst {
  double error = 0;
  void see(double error_here) {
    if (!(error_here <= error)) error = error_here;  // NaN counts as worst
  }
};

std::vector<float> numbers(std::size_t count, float low, float high) {
  std::vector<float> v(count);
  for (std::size_t i = 0; i < count; ++i) {
    v[i] = low + (high - low) * static_cast<float>(i) / static_cast<float>(count);
  }
  return v;
}

// Returns positive normal numbers of every exponent.
std::vector<float> all_exponents(std::size_t each) {
  test::Dice dice(3);
  std::vector<float> v;
  for (std::uint32_t exponent = 1; exponent < 255; ++exponent) {
    for (std::size_t i = 0; i < each; ++i) {
      std::uint32_t mantissa = static_cast<std::uint32_t>(dice.word()) & 0x7fffffu;
      if (i == 0) mantissa = 0;
      if (i == 1) mantissa = 0x7fffffu;
      const std::uint32_t bits = exponent << 23 | mantissa;
      float value;
      std::memcpy(&value, &bits, 4);
      v.push_back(value);
    }
  }
  return v;
}

}  // namespace

TEST(cos_and_sin_of_turns) {
  const std::vector<float> turn = numbers(1 << 20, 0, 1);
  for (const test::Build& build : test::builds()) {
    std::vector<float> c(turn.size()), s(turn.size());
    build.probe.cos_sin_turn(turn.data(), turn.size(), c.data(), s.data());
    Worst worst, circle;
    for (std::size_t i = 0; i < turn.size(); ++i) {
      worst.see(static_cast<double>(std::fabs(c[i] - std::cos(kTurn * turn[i]))));
      worst.see(static_cast<double>(std::fabs(s[i] - std::sin(kTurn * turn[i]))));
      circle.see(std::fabs(double{c[i]} * c[i] + double{s[i]} * s[i] - 1));
    }
    CHECK_NEAR(worst.error, 0, 1.1e-7);
    CHECK_NEAR(circle.error, 0, 2e-7);
    CHECK(c[0] == 1 && s[0] == 0);
    CHECK(s[turn.size() / 4] == 1 && c[turn.size() / 2] == -1);
  }
}

TEST(log_of_normal_numbers) {
  std::vector<float> v = all_exponents(256);
  const std::vector<float> near_one = numbers(1 << 16, 0.5f, 2);
  v.insert(v.end(), near_one.begin(), near_one.end());
  for (const test::Build& build : test::builds()) {
    std::vector<float> out(v.size());
    build.probe.log(v.data(), v.size(), out.data());
    Worst worst;
    for (std::size_t i = 0; i < v.size(); ++i) {
      const long double exact = std::log(static_cast<long double>(v[i]));
      worst.see(static_cast<double>(std::fabs(out[i] - exact) / std::fmax(1.0L, std::fabs(exact))));
    }
    CHECK_NEAR(worst.error, 0, 2e-7);
  }
}

TEST(cube_root_of_normal_numbers) {
  std::vector<float> v = all_exponents(256);
  std::erase_if(v, [](float x) { return x > 1e38f; });  // beyond that, the cube of a first guess is infinite
  while (v.size() % 16 != 0) v.pop_back();
  for (const test::Build& build : test::builds()) {
    std::vector<float> out(v.size());
    build.probe.cube_root(v.data(), v.size(), out.data());
    Worst worst;
    for (std::size_t i = 0; i < v.size(); ++i) {
      const long double exact = std::cbrt(static_cast<long double>(v[i]));
      worst.see(static_cast<double>(std::fabs(out[i] - exact) / exact));
    }
    CHECK_NEAR(worst.error, 0, 2e-7);
    std::vector<float> zeros(16), roots(16, 1);
    build.probe.cube_root(zeros.data(), zeros.size(), roots.data());
    CHECK(roots[0] == 0);
  }
}

TEST(elementary_functions_have_the_same_bits_in_every_build) {
  std::vector<float> v = all_exponents(64);
  const std::vector<float> turn = numbers(1 << 16, 0, 1);
  const auto builds = test::builds();
  std::vector<float> first(v.size()), other(v.size()), c(turn.size()), s(turn.size()), c2(turn.size()), s2(turn.size());
  builds[0].probe.cos_sin_turn(turn.data(), turn.size(), c.data(), s.data());
  for (const test::Build& build : builds) {
    for (const auto function : {&test::Probe::log, &test::Probe::cube_root}) {
      (builds[0].probe.*function)(v.data(), v.size(), first.data());
      (build.probe.*function)(v.data(), v.size(), other.data());
      CHECK(std::memcmp(first.data(), other.data(), v.size() * sizeof(float)) == 0);
    }
    build.probe.cos_sin_turn(turn.data(), turn.size(), c2.data(), s2.data());
    CHECK(std::memcmp(c.data(), c2.data(), c.size() * sizeof(float)) == 0);
    CHECK(std::memcmp(s.data(), s2.data(), s.size() * sizeof(float)) == 0);
  }
}

}  // namespace motes::test_elementary
