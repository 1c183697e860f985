// Computes where to cut bricks, from all calculators' particles counted in boxes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "domains/domains.h"

namespace motes::balance {

/// Particles in a box of space: low <= x <= high along each axis that is cut.
struct Cell {
  std::array<float, 3> low{}, high{};
  std::uint64_t count = 0;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Cell& cell) {
  visit(cell.low, cell.high, cell.count);
}

/// Counts one calculator's particles in at most `most` boxes along the axes that are cut, with about equally many in
/// each. A sample chooses the boxes, but all particles are counted, and each box is the bounding box of its particles.
/// Particles with a non-finite coordinate are ignored.
std::vector<Cell> cells(domains::Axes axes, const domains::Places& places, int most);

/// Computes all cuts of a tree at once: domain c gets shares[c] of the sum of counts * costs (costs empty: 1 each).
/// There is one list of cells and one cost per calculator. Cells may overlap; particles count as evenly spread over
/// their cell. Each cut keeps its axis. Where a gap between particles or an empty part of space leaves a choice, a cut
/// stays as close to `before` as possible.
domains::Domains tree_cuts(std::span<const std::vector<Cell>> cells, std::span<const double> costs,
                           std::span<const double> shares, const domains::Domains& before);

}  // namespace motes::balance
