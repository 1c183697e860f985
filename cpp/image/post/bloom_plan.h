// How bloom divides a picture into cells: three levels, each coarser than the one before it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "image/grid.h"
#include "image/post/bloom_lanes.h"

namespace motes::image {

/// One axis of a level: `fine` finer cells (pixels, or cells of the next finer level) are divided evenly into `cells`.
struct BloomAxis {
  static constexpr int kWeightBits = 10;  // fractional bits of weights, which add up to one

  int fine = 1, cells = 1;
  Taps taps;

  // Cell c averages finer cells from first[c] on, with weights[begin[c]] .. weights[begin[c + 1] - 1].
  std::vector<int> first;
  std::vector<std::size_t> begin;
  std::vector<std::uint32_t> weights;

  // Finer cell i lies between the centres of cell before[i] (-1: before the first cell) and of the next one, at
  // beyond[i] of the way, in 2^-BetweenLanes::kBits.
  std::vector<int> before;
  std::vector<std::uint64_t> beyond;

  /// Returns the cell itself, or the nearest one that exists.
  int nearest(int cell) const { return cell < 0 ? 0 : cell < cells ? cell : cells - 1; }
};

/// A rectangle of a level's cells; rows have three lanes per cell.
struct CellArea {
  int x = 0, y = 0, width = 0, height = 0;

  std::size_t row_lanes() const { return static_cast<std::size_t>(width) * 3; }
  std::size_t lanes() const { return row_lanes() * static_cast<std::size_t>(height); }
};

/// The cells of all levels, and their shares of light. They depend only on the picture's size and its bloom, so they
/// are equal on all ranks.
struct BloomPlan {
  struct Level {
    BloomAxis across, down;
    std::uint32_t share = 0;  // of the light, in 2^-16

    // For each lane of a finer row: the lanes of a row of cells between which it lies, and how far beyond the first.
    std::vector<std::uint32_t> left, right;
    std::vector<std::uint64_t> beyond;
  };

  /// Fractional bits of a cell's average: light that spreads far is faint.
  static constexpr int kFraction = 12;

  int width = 0, height = 0;
  std::uint32_t part = 0;  // fraction of the light that spreads, in 2^-16
  std::array<Level, 3> levels;

  /// Makes the plan. Throws std::invalid_argument if `part_of_light` is not in 0..1, or the picture has no pixel.
  void make(int width, int height, float part_of_light);

  /// Returns the cells of the finest level into which a tile's pixels are averaged and from which its glow is computed.
  CellArea cells(const Area& tile) const;
};

}  // namespace motes::image
