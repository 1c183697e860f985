// What is cut: axes of space, a curve through its cells, or the ids.
#pragma once

#include <bit>
#include <cstdint>
#include <string>

namespace motes::domains {

/// Axis numbers that stand for the ids and for places along a curve.
inline constexpr int kById = 3;
inline constexpr int kMorton = 4;
inline constexpr int kHilbert = 5;

/// One axis: slabs. Two or three: bricks. A curve: stretches of it. None: particles are distributed by id, wherever
/// they are.
struct Axes {
  std::uint8_t bits = 1;  // 1: x, 2: y, 4: z; 16, 32: a curve

  /// Returns whether domains are in a row, so neighbours can exchange particles at their common end.
  constexpr bool row() const { return std::popcount(bits) == 1; }
  constexpr bool bricks() const { return std::popcount(bits) > 1; }
  constexpr bool curve() const { return bits == 1u << kMorton || bits == 1u << kHilbert; }
  constexpr bool by_id() const { return bits == 0; }
  constexpr bool valid() const { return bits < 8 || curve(); }
  /// Returns whether domains are cut along an axis of space, 0..2.
  constexpr bool has(int axis) const { return (bits >> axis & 1) != 0; }
  /// Returns the lowest axis; kById if there is none.
  constexpr int first() const { return bits == 0 ? kById : std::countr_zero(bits); }

  bool operator==(const Axes&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Axes& axes) {
  visit(axes.bits);
}

/// Returns the name of an axis: "x", "y", "z", "id", "morton" or "hilbert".
constexpr const char* name_of(int axis) {
  constexpr const char* kNames[] = {"x", "y", "z", "id", "morton", "hilbert"};
  return kNames[axis];
}

/// Returns the name of axes, such as "x", "xz", "xyz", "morton", "hilbert", or "id" if ids decide.
inline std::string name_of(Axes axes) {
  if (axes.curve()) return name_of(axes.first());
  std::string name;
  for (int axis = 0; axis < 3; ++axis) {
    if (axes.has(axis)) name += "xyz"[axis];
  }
  return name.empty() ? "id" : name;
}

/// Returns the axes with such a name.
inline Axes axes_of(const std::string& name) {
  if (name == name_of(kMorton)) return {1u << kMorton};
  if (name == name_of(kHilbert)) return {1u << kHilbert};
  Axes axes{0};
  for (int axis = 0; axis < 3 && name != "id"; ++axis) {
    if (name.find("xyz"[axis]) != std::string::npos) axes.bits |= static_cast<std::uint8_t>(1u << axis);
  }
  return axes;
}

}  // namespace motes::domains
