#include "particles/rows.h"

#include <bit>
#include <cstdint>

namespace motes::particles {
namespace {

template <class Number, int kWidth>
bool copy(const Number* rows, std::size_t first, std::size_t last, float* const* planes) {
  constexpr std::uint32_t kExponent = 0x7f800000, kLowestOfIt = 0x00800000, kSign = 0x80000000;
  float* to[kWidth];
  for (int c = 0; c < kWidth; ++c) to[c] = planes[c];
  std::uint32_t carry = 0;  // its sign is set if any exponent was full
  for (std::size_t i = first; i < last; ++i) {
    for (int c = 0; c < kWidth; ++c) {
      const auto value = static_cast<float>(rows[static_cast<std::size_t>(kWidth) * i + static_cast<std::size_t>(c)]);
      carry |= (std::bit_cast<std::uint32_t>(value) & kExponent) + kLowestOfIt;
      to[c][i] = value;
    }
  }
  return (carry & kSign) == 0;
}

template <class Number>
bool copy(const GivenRows& rows, std::size_t first, std::size_t last, float* const* planes) {
  const auto* from = static_cast<const Number*>(rows.numbers);
  return rows.width == 1 ? copy<Number, 1>(from, first, last, planes) : copy<Number, 3>(from, first, last, planes);
}

}  // namespace

bool to_planes(const GivenRows& rows, std::size_t first, std::size_t last, float* const* planes) {
  return rows.doubles ? copy<double>(rows, first, last, planes) : copy<float>(rows, first, last, planes);
}

}  // namespace motes::particles
