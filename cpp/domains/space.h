// Parts of space, and places in it.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "particles/ids.h"

namespace motes::domains {

/// Half the width of the paper's infinite space, in metres.
inline constexpr float kInfinite = 1048576.0f;  // 2^20

/// How a system's space is divided at the start (API: World.space).
struct Space {
  enum class Kind : unsigned char { finite, infinite, fit };
  Kind kind = Kind::infinite;
  double low = 0;   // metres, kind finite; the same interval along each axis that is cut
  double high = 0;

  bool operator==(const Space&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Space& space) {
  visit(space.kind, space.low, space.high);
}

/// A part of space, half-open: low <= x < high along each axis. Outer faces are at infinity.
struct Box {
  static constexpr float kInf = std::numeric_limits<float>::infinity();
  std::array<float, 3> low{-kInf, -kInf, -kInf};
  std::array<float, 3> high{kInf, kInf, kInf};

  bool operator==(const Box&) const = default;
};

/// A part of space that is bounded on every side, metres.
struct Room {
  std::array<double, 3> low, high;

  double side(int axis) const { return high[static_cast<std::size_t>(axis)] - low[static_cast<std::size_t>(axis)]; }
};

/// Positions and ids of particles. Only those that the domains need must be set: the planes of the axes that are cut,
/// all three for a curve, or the ids.
struct Places {
  std::array<const float*, 3> position{};  // x, y, z
  particles::Ids ids;
  std::size_t count = 0;
};

}  // namespace motes::domains
