// Vectors of 16-bit numbers compared with plain loops.
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "support/check.h"
#include "support/isas.h"

namespace motes::test_shorts {
namespace {

constexpr std::size_t kMost = 16;  // lanes

}  // namespace

TEST(sums_of_products_of_texels_in_pairs) {
  test::Dice dice(31);
  std::array<std::uint16_t, 8 * kMost> texels{};
  std::array<std::int32_t, kMost> weights{};
  for (auto& t : texels) t = static_cast<std::uint16_t>(dice.below(32768));
  for (auto& w : weights) w = static_cast<std::int32_t>(dice.below(16385) | dice.below(16385) << 16);
  for (const test::Build& build : test::builds()) {
    std::array<std::int32_t, 4 * kMost> sums{};
    build.probe.pairs(texels.data(), weights.data(), sums.data());
    for (std::size_t i = 0; i < kMost; ++i) {
      for (std::size_t c = 0; c < 4; ++c) {
        const int first = texels[8 * i + c], second = texels[8 * i + 4 + c];
        CHECK(sums[kMost * c + i] == first * (weights[i] & 0xffff) + second * (weights[i] >> 16));
      }
    }
  }
}

TEST(numbers_of_three_planes_in_turn) {
  for (const test::Build& build : test::builds()) {
    std::array<std::int32_t, 3 * kMost> planes{};
    for (std::size_t i = 0; i < planes.size(); ++i) planes[i] = static_cast<std::int32_t>(32767 - 500 * i);
    constexpr std::uint16_t kUntouched = 7;
    std::vector<std::uint16_t> out(3 * kMost + 2, kUntouched);
    build.probe.thirds(planes.data(), out.data());
    for (std::size_t n = 0; n < 3 * kMost; ++n) CHECK(int{out[n]} == planes[n % 3 * kMost + n / 3]);
    CHECK(int{out.back()} == int{kUntouched});  // one number at most is overwritten
  }
}

TEST(the_greatest_number_wherever_it_is) {
  for (const test::Build& build : test::builds()) {
    const std::size_t count = 2 * build.probe.lanes;
    for (std::size_t at = 0; at < count; ++at) {
      std::array<std::int16_t, 2 * kMost> numbers{};
      for (std::size_t i = 0; i < count; ++i) numbers[i] = static_cast<std::int16_t>(i * 37 % 100);
      numbers[at] = 32767;
      CHECK(build.probe.greatest(numbers.data()) == 32767);
      numbers[at] = 101;
      CHECK(build.probe.greatest(numbers.data()) == 101);
    }
  }
}

}  // namespace motes::test_shorts
