// gravitate(far="cells"): groups distant particles into cells (Barnes-Hut) of a pyramid of levels over a cube that
// holds all particles. Moments of cells are integers, so their sums over all ranks have the same bits in any order.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "actions/action.h"
#include "interactions/act.h"

namespace motes::interactions {

/// Returns whether the action groups distant particles into cells.
bool uses_cells(const actions::Action& action);

/// Bounds of finite particles: maxima of x, y, z and of -x, -y, -z; -infinity if there are none.
using Bounds = std::array<float, 6>;
Bounds bounds_of(const particles::Store& store);

/// The cube: 2^bits leaves along each axis. Leaves are anchored at the origin; their edge is a power of two.
struct Cube {
  int bits = 2;
  double leaf = 1;  // m
  std::array<std::int32_t, 3> low{};  // index of its first leaf along each axis

  /// Returns a cube around `bounds`, with about twelve particles per leaf if they are spread evenly. All ranks must
  /// agree on the arguments.
  static Cube around(const Bounds& bounds, std::uint64_t particles);

  std::size_t leaves() const { return std::size_t{1} << 3 * bits; }
};

/// Four integers per leaf; coordinates are in units of the cube's edge / 2^20:
///
///   [count, sum of x, sum of y, sum of z] [count, ...] ...
using Moments = std::vector<std::int64_t>;
Moments moments_of(const Cube& cube, const particles::Store& store);

/// Acts on this rank's particles: sources in the 27 leaves around a particle are summed one by one, the others as
/// cells. `moments`: sums over all ranks.
InteractionCounts act_by_cells(const actions::Action& action, const Cube& cube, const Moments& moments, float dt,
                               const Side& side, Scratch& scratch, threads::Pool& pool);

}  // namespace motes::interactions
