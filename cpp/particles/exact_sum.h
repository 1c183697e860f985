// Sums of float32 numbers without rounding: integers, so that they come to the same in any order and any parts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace motes::particles {

/// A sum of up to 2^64 float32 numbers as an integer of 384 bits, in units of 2^-149: that is the smallest number of
/// float32, and its largest is below 2^128, so 149 + 128 + 64 bits and a sign are enough. Infinities and NaN are
/// remembered, in whatever order they come: a sum with NaN, or with both infinities, is NaN; a sum with one is that
/// one.
class ExactSum {
 public:
  void add(float value);
  ExactSum& operator+=(const ExactSum& other);

  /// Adds magnitude * 2^(shift - 149), or subtracts it. The shift is less than 256.
  void add_shifted(std::uint64_t magnitude, unsigned shift, bool negative);
  /// Adds what is not finite: an infinity, or NaN.
  void add_special(float value);

  /// The nearest double; of two that are equally near, the even one. A sum of nothing, or of zeros, is +0.
  double rounded() const;

  /// Whether it is a finite sum of exactly 0.
  bool zero() const;
  bool operator==(const ExactSum&) const = default;

 private:
  static constexpr std::size_t kLimbs = 6;

  // The highest limb of a finite sum is within +-2^21. This pattern in its three highest bits stands for a sum that is
  // not finite; its lowest bits then say what came in, and the other limbs are 0.
  static constexpr std::uint64_t kSpecial = std::uint64_t{2} << 61;
  bool special() const { return limbs_[kLimbs - 1] >> 61 == kSpecial >> 61; }
  void note_special(std::uint64_t kinds);

  std::array<std::uint64_t, kLimbs> limbs_{};  // lowest first, two's complement
};
static_assert(sizeof(ExactSum) == 48);

/// Many numbers for one sum: an addition to a table by sign and exponent each. Takes 2^40 of them.
class FloatTable {
 public:
  void add(std::span<const float> values);
  void add_to(ExactSum& sum) const;

 private:
  // Numbers of one sign and exponent often follow each other, and additions to one place wait for each other: the
  // tables take turns.
  static constexpr std::size_t kTables = 4;
  std::array<std::array<std::uint64_t, 512>, kTables> mantissas_{};
  ExactSum specials_;
};

}  // namespace motes::particles
