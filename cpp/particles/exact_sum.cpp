#include "particles/exact_sum.h"

#include <bit>
#include <cmath>
#include <limits>

namespace motes::particles {
namespace {

constexpr int kLowestBit = -149;  // the exponent of the lowest bit
constexpr std::uint64_t kNan = 1, kPlusInfinity = 2, kMinusInfinity = 4;
constexpr std::uint32_t kMantissa = 0x7fffff;
constexpr std::uint32_t kNotFinite = 255;  // the exponent of infinities and NaN

/// Adds `value` and a carry of 0 or 1; returns the carry.
std::uint64_t add_carrying(std::uint64_t& limb, std::uint64_t value, std::uint64_t carry) {
  const bool first = __builtin_add_overflow(limb, value, &limb);
  const bool second = __builtin_add_overflow(limb, carry, &limb);
  return first || second ? 1 : 0;
}

// Numbers of exponent 0 (subnormals) have no leading 1, and the same unit as those of exponent 1.
std::uint64_t mantissa_of(std::uint32_t bits, std::uint32_t exponent) {
  return (bits & kMantissa) + (std::uint64_t{exponent != 0} << 23);
}
unsigned shift_of(std::uint32_t exponent) { return exponent - (exponent != 0 ? 1 : 0); }

/// Rounds a positive integer (lowest limb first) times 2^kLowestBit to double.
template <std::size_t kLimbs>
double rounded_magnitude(const std::array<std::uint64_t, kLimbs>& limbs) {
  std::size_t top = kLimbs - 1;
  while (limbs[top] == 0) --top;
  const int spare = std::countl_zero(limbs[top]);
  const std::uint64_t below = top > 0 ? limbs[top - 1] : 0;
  const std::uint64_t leading = spare == 0 ? limbs[top] : limbs[top] << spare | below >> (64 - spare);
  bool more = spare > 0 ? below << spare != 0 : below != 0;  // whether bits are set behind the 64 leading ones
  for (std::size_t i = 0; i + 1 < top; ++i) more = more || limbs[i] != 0;
  constexpr std::uint64_t kHalf = 1u << 10;
  std::uint64_t kept = leading >> 11;
  const std::uint64_t rest = leading & (2 * kHalf - 1);
  if (rest > kHalf || (rest == kHalf && (more || (kept & 1u) != 0))) ++kept;
  return std::ldexp(static_cast<double>(kept), static_cast<int>(64 * top) - spare + 11 + kLowestBit);
}

}  // namespace

void ExactSum::add(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t exponent = bits >> 23 & 0xffu;
  if (exponent == kNotFinite) return add_special(value);
  add_shifted(mantissa_of(bits, exponent), shift_of(exponent), bits >> 31 != 0);
}

void ExactSum::add_shifted(std::uint64_t magnitude, unsigned shift, bool negative) {
  if (special()) return;
  const std::uint64_t sign = negative ? ~std::uint64_t{0} : 0;  // -x is ~x + 1
  std::size_t i = shift / 64;
  const unsigned bit = shift % 64;
  std::uint64_t carry = add_carrying(limbs_[i], magnitude << bit ^ sign, sign & 1u);
  carry = add_carrying(limbs_[i + 1], magnitude >> 1 >> (63 - bit) ^ sign, carry);
  for (i += 2; i < kLimbs && carry != (sign & 1u); ++i) carry = add_carrying(limbs_[i], sign, carry);
}

void ExactSum::add_special(float value) {
  note_special(std::isnan(value) ? kNan : value > 0 ? kPlusInfinity : kMinusInfinity);
}

void ExactSum::note_special(std::uint64_t kinds) {
  if (special()) kinds |= limbs_[kLimbs - 1];
  limbs_ = {};
  limbs_[kLimbs - 1] = kinds | kSpecial;
}

ExactSum& ExactSum::operator+=(const ExactSum& other) {
  if (other.special()) {
    note_special(other.limbs_[kLimbs - 1]);
  } else if (!special()) {
    std::uint64_t carry = 0;
    for (std::size_t i = 0; i < kLimbs; ++i) carry = add_carrying(limbs_[i], other.limbs_[i], carry);
  }
  return *this;
}

double ExactSum::rounded() const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (special()) {
    const std::uint64_t kinds = limbs_[kLimbs - 1] & (kNan | kPlusInfinity | kMinusInfinity);
    if (kinds == kPlusInfinity) return kInfinity;
    if (kinds == kMinusInfinity) return -kInfinity;
    return std::numeric_limits<double>::quiet_NaN();
  }
  if (zero()) return 0;
  if (limbs_[kLimbs - 1] >> 63 == 0) return rounded_magnitude(limbs_);
  std::array<std::uint64_t, kLimbs> magnitude{};
  std::uint64_t carry = 1;
  for (std::size_t i = 0; i < kLimbs; ++i) carry = add_carrying(magnitude[i], ~limbs_[i], carry);
  return -rounded_magnitude(magnitude);
}

bool ExactSum::zero() const { return *this == ExactSum{}; }

void FloatTable::add(std::span<const float> values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto bits = std::bit_cast<std::uint32_t>(values[i]);
    const std::uint32_t exponent = bits >> 23 & 0xffu;
    if (exponent == kNotFinite) {
      specials_.add_special(values[i]);
    } else {
      mantissas_[i % kTables][bits >> 23] += mantissa_of(bits, exponent);
    }
  }
}

void FloatTable::add_to(ExactSum& sum) const {
  for (const auto& table : mantissas_) {
    for (std::uint32_t i = 0; i < table.size(); ++i) {
      if (table[i] != 0) sum.add_shifted(table[i], shift_of(i & 0xffu), i >= 256);
    }
  }
  sum += specials_;
}

}  // namespace motes::particles
