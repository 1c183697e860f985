// gravitate without a reach, where far particles count as cells: a pyramid of cells over a cube that holds all of them.
// Moments of cells are sums of integers, so those of all ranks add up to the same bits in any order.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "actions/action.h"
#include "interactions/act.h"

namespace motes::interactions {

/// Whether the action asks for cells.
bool uses_cells(const actions::Action& action);

/// Where finite particles are: maxima of x, y, z and of -x, -y, -z; -infinity where there are none.
using Bounds = std::array<float, 6>;
Bounds bounds_of(const particles::Store& store);

/// The cube: 2^bits leaves along each axis, anchored at the origin of space, with edges of a power of two.
struct Cube {
  int bits = 2;
  double leaf = 1;  // m
  std::array<std::int32_t, 3> low{};  // number of its first leaf along each axis

  /// `bounds` and `particles` are agreed on by all ranks. About twelve particles per leaf, where they are spread
  /// evenly.
  static Cube around(const Bounds& bounds, std::uint64_t particles);

  std::size_t leaves() const { return std::size_t{1} << 3 * bits; }
};

/// Of each leaf: the number of its particles, and the sums of their coordinates in 20 bits of the cube's edge.
using Moments = std::vector<std::int64_t>;
Moments moments_of(const Cube& cube, const particles::Store& store);

/// Acts on one rank's particles: those in the 27 leaves around each are seen as they are, the others as cells.
/// `moments`: of all ranks.
Seen act_by_cells(const actions::Action& action, const Cube& cube, const Moments& moments, float dt, const Side& side,
                  Scratch& scratch, threads::Pool& pool);

}  // namespace motes::interactions
