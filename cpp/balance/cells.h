// Where to cut bricks: from all calculators' particles, counted in boxes.
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

/// How one calculator's particles lie along the axes that are cut: at most `most` boxes, with about equally many in
/// each. A sample chooses them; all particles are counted, and a box is no larger than what it holds. Particles with a
/// coordinate that is not finite are left out.
std::vector<Cell> cells(domains::Axes axes, const domains::Places& places, int most);

/// All cuts of a tree at once: domain c gets shares[c] of the sum of counts * costs (costs empty: 1 each). One list of
/// cells and one cost per calculator; cells may overlap, and what is in one counts as evenly spread. Each cut keeps its
/// axis, and where a gap between particles or an empty part of space leaves a choice, it stays as close to `before` as
/// possible.
domains::Domains tree_cuts(std::span<const std::vector<Cell>> cells, std::span<const double> costs,
                           std::span<const double> shares, const domains::Domains& before);

}  // namespace motes::balance
