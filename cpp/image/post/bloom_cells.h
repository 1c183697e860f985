// Interpolates the light of cells to finer cells or pixels between their centres.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "image/post/bloom_plan.h"

namespace motes::image {

/// The light of a rectangle of cells.
struct BloomCells {
  CellArea area;
  const std::uint64_t* first = nullptr;
  std::size_t row_lanes = 0;  // lanes from row to row

  const std::uint64_t* row(int y) const { return first + static_cast<std::size_t>(y - area.y) * row_lanes; }
};

/// Working memory of a thread: two rows of cells interpolated to finer columns, a finer row of glow, and its difference
/// to the next row.
struct GlowRows {
  std::vector<std::uint64_t> near, far, glow, step;
};

/// Calls mix(y, rows) for each finer row of a rectangle. rows.glow is its glow times 2^BetweenLanes::kBits; mix() must
/// add rows.step to it for the next row. Glow is linear between the cells' centres, and constant beyond the outermost
/// ones. Steps always count from the first finer row between two centres, even if the rectangle begins at a later one,
/// so pixels do not depend on how a picture is divided. Arithmetic is modulo 2^64; steps are rounded down, so glow is
/// never below that of the darker cell.
template <class Mix>
void enlarge(const BloomLanes& kernels, const BloomPlan::Level& level, const BloomCells& cells, const Area& finer,
             GlowRows& rows, const Mix& mix) {
  const BloomAxis& down = level.down;
  const std::size_t lanes = static_cast<std::size_t>(finer.width) * 3, x = static_cast<std::size_t>(finer.x) * 3;
  const BetweenLanes between{level.left.data() + x, level.right.data() + x, level.beyond.data() + x,
                             static_cast<std::uint32_t>(cells.area.x) * 3};
  const auto before = [&](int y) { return down.before[static_cast<std::size_t>(y)]; };
  const auto widen = [&](int cell) { kernels.widen(rows.far.data(), cells.row(down.nearest(cell)), between, lanes); };
  for (auto* row : {&rows.near, &rows.far, &rows.glow, &rows.step}) row->resize(lanes);
  const std::uint64_t slope =
      (static_cast<std::uint64_t>(down.cells) << BetweenLanes::kBits) / static_cast<std::uint64_t>(down.fine);
  const int end = finer.y + finer.height;
  int y = finer.y, first = y, cell = before(y);
  while (first > 0 && before(first - 1) == cell) --first;
  widen(cell);
  for (; y < end; first = y, ++cell) {
    std::swap(rows.near, rows.far);
    widen(cell + 1);
    const std::uint64_t beyond =
        down.beyond[static_cast<std::size_t>(first)] + static_cast<std::uint64_t>(y - first) * slope;
    kernels.start(rows.glow.data(), rows.step.data(), rows.near.data(), rows.far.data(), beyond, slope, lanes);
    for (; y < end && before(y) == cell; ++y) mix(y, rows);
  }
}

}  // namespace motes::image
