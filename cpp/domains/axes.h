// Which axes of space are cut.
#pragma once

#include <bit>
#include <cstdint>
#include <string>

namespace motes::domains {

/// Stands for an axis where ids decide.
inline constexpr int kById = 3;

/// One axis: slabs. Two or three: bricks. None: particles are dealt out by id, wherever they are.
struct Axes {
  std::uint8_t bits = 1;  // 1: x, 2: y, 4: z

  constexpr bool slabs() const { return std::popcount(bits) == 1; }
  constexpr bool bricks() const { return std::popcount(bits) > 1; }
  constexpr bool by_id() const { return bits == 0; }
  constexpr bool has(int axis) const { return (bits >> axis & 1) != 0; }
  /// The lowest; kById where there is none.
  constexpr int first() const { return bits == 0 ? kById : std::countr_zero(bits); }

  bool operator==(const Axes&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Axes& axes) {
  visit(axes.bits);
}

/// "x", "xz", "xyz"; "id" where ids decide.
inline std::string name_of(Axes axes) {
  std::string name;
  for (int axis = 0; axis < 3; ++axis) {
    if (axes.has(axis)) name += "xyz"[axis];
  }
  return name.empty() ? "id" : name;
}

}  // namespace motes::domains
