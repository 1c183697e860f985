// The periods of space. Along a periodic axis, positions wrap at the ends of an interval: particles that leave at one
// end enter at the other.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace motes::particles {

/// The most crossings that are counted at once, to keep their sum finite.
inline constexpr double kMostCrossings = 1e37;

/// A position along a periodic axis, and how often it crossed the upper end; negative: the lower end.
struct Wrapped {
  float at = 0;  // metres
  float crossed = 0;
};

/// The half-open interval [low, high), m, of positions along a periodic axis.
struct Period {
  float low = 0, high = 0;

  /// Returns the length, m, in double.
  double length() const { return static_cast<double>(high) - static_cast<double>(low); }

  /// Returns whether a position needs no wrapping. False for NaN, which wrapped() returns unchanged.
  bool holds(float x) const { return x >= low && x < high; }

  /// Wraps x into the interval. Infinities and NaN stay unchanged. The position plus the crossings times length()
  /// differs from x only by rounding.
  Wrapped wrapped(float x) const {
    if (holds(x) || !std::isfinite(x)) return {x, 0};
    const double along = length();
    double crossed = std::floor((static_cast<double>(x) - static_cast<double>(low)) / along);
    float at = static_cast<float>(static_cast<double>(x) - crossed * along);
    if (at < low) at = low;  // rounding, far from the origin
    if (at >= high) {        // just below an end, where float32 has no number between
      at = low;
      crossed += 1;
    }
    return {at, static_cast<float>(std::clamp(crossed, -kMostCrossings, kMostCrossings))};
  }

  /// Returns the shift, m, that makes a displacement between two positions in the interval lead to the nearest image:
  /// 0, or plus or minus a period.
  double shift(float way) const {
    const double along = length();
    if (static_cast<double>(way) > along / 2) return -along;
    return static_cast<double>(way) < -along / 2 ? along : 0;
  }

  /// Returns the shortest displacement, m, from one position in the interval to another one or its images.
  float shortest(float way) const {
    const double by = shift(way);
    return by == 0 ? way : static_cast<float>(static_cast<double>(way) + by);  // keeps -0
  }

  bool operator==(const Period&) const = default;
};

/// The periodic axes of space and their intervals.
struct Periods {
  std::uint8_t bits = 0;  // 1: x, 2: y, 4: z
  std::array<Period, 3> along{};

  bool any() const { return bits != 0; }
  bool has(int axis) const { return (bits >> axis & 1) != 0; }
  const Period& operator[](int axis) const { return along[static_cast<std::size_t>(axis)]; }
  float shortest(int axis, float way) const { return has(axis) ? (*this)[axis].shortest(way) : way; }
  double shift(int axis, float way) const { return has(axis) ? (*this)[axis].shift(way) : 0; }

  /// Returns half of the shortest period, m; infinite if no axis is periodic.
  float half() const {
    double least = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (has(axis)) least = std::min(least, (*this)[axis].length() / 2);
    }
    return static_cast<float>(least);
  }

  bool operator==(const Periods&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Period& period) {
  visit(period.low, period.high);
}

template <class Visitor>
constexpr void fields(Visitor& visit, Periods& periods) {
  visit(periods.bits, periods.along);
}

}  // namespace motes::particles
