// Exact sums of float32 numbers: integers, so the result does not depend on the order or grouping of the numbers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace motes::particles {

/// A sum of up to 2^64 float32 numbers as an integer of 384 bits, in units of 2^-149, the smallest float32. The largest
/// is below 2^128, so 149 + 128 + 64 bits and a sign are enough. In any order, a sum with NaN or with both infinities
/// is NaN; a sum with one infinity is that infinity.
class ExactSum {
 public:
  void add(float value);
  ExactSum& operator+=(const ExactSum& other);

  /// Adds magnitude * 2^(shift - 149), or subtracts it if `negative`. `shift` must be less than 256.
  void add_shifted(std::uint64_t magnitude, unsigned shift, bool negative);
  /// Adds an infinity or NaN.
  void add_special(float value);

  /// Returns the sum as the nearest double, with ties to even. An empty sum, or one of zeros, is +0.
  double rounded() const;

  /// Returns whether the sum is finite and exactly 0.
  bool zero() const;
  bool operator==(const ExactSum&) const = default;

 private:
  static constexpr std::size_t kLimbs = 6;

  // The highest limb of a finite sum is within +-2^21. This pattern in its three highest bits marks a sum that is not
  // finite; its lowest bits then tell which special values were added, and the other limbs are 0.
  static constexpr std::uint64_t kSpecial = std::uint64_t{2} << 61;
  template <class Visitor>
  friend constexpr void fields(Visitor& visit, ExactSum& sum) {
    visit(sum.limbs_);
  }

  bool special() const { return limbs_[kLimbs - 1] >> 61 == kSpecial >> 61; }
  void note_special(std::uint64_t kinds);

  std::array<std::uint64_t, kLimbs> limbs_{};  // lowest first, two's complement
};
static_assert(sizeof(ExactSum) == 48);

/// Accumulates up to 2^40 numbers for one sum, with one addition per number to a table by sign and exponent.
class FloatTable {
 public:
  void add(std::span<const float> values);
  void add_to(ExactSum& sum) const;

 private:
  // Consecutive numbers often have the same sign and exponent, and additions to one entry wait for each other, so the
  // tables take turns.
  static constexpr std::size_t kTables = 4;
  std::array<std::array<std::uint64_t, 512>, kTables> mantissas_{};
  ExactSum specials_;
};

}  // namespace motes::particles
