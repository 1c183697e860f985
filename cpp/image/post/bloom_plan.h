// How bloom divides a picture into cells: three levels, each coarser than the one before it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "image/grid.h"
#include "image/post/bloom_lanes.h"

namespace motes::image {

/// One direction of a level: `fine` pixels, or cells of the next finer level, are divided evenly into `cells`.
struct BloomAxis {
  static constexpr int kWeightBits = 10;  // of weights that add up to one

  int fine = 1, cells = 1;
  Taps taps;

  // Cell c averages the finer ones from first[c], with weights[begin[c]] .. weights[begin[c + 1] - 1].
  std::vector<int> first;
  std::vector<std::size_t> begin;
  std::vector<std::uint32_t> weights;

  // Finer one i lies between two cells' centres: before[i] (-1: before all) and the next, so far beyond the first, in
  // 2^-BetweenLanes::kBits.
  std::vector<int> before;
  std::vector<std::uint64_t> beyond;

  /// The cell itself, or the nearest one that there is.
  int nearest(int cell) const { return cell < 0 ? 0 : cell < cells ? cell : cells - 1; }
};

/// A rectangle of a level's cells; rows have three lanes per cell.
struct CellArea {
  int x = 0, y = 0, width = 0, height = 0;

  std::size_t row_lanes() const { return static_cast<std::size_t>(width) * 3; }
  std::size_t lanes() const { return row_lanes() * static_cast<std::size_t>(height); }
};

/// Depends on the size of the picture only, but for the shares of light; all ranks find the same.
struct BloomPlan {
  struct Level {
    BloomAxis across, down;
    std::uint32_t share = 0;  // of the light, in 2^-16

    // For each lane of a finer row: the lanes that it lies between in a row of cells, and how far beyond the first.
    std::vector<std::uint32_t> left, right;
    std::vector<std::uint64_t> beyond;
  };

  /// Bits after the point of a cell's average: what spreads far is faint.
  static constexpr int kFraction = 12;

  int width = 0, height = 0;
  std::uint32_t part = 0;  // of the light that spreads, in 2^-16
  std::array<Level, 3> levels;

  /// Throws std::invalid_argument where `part_of_light` is not in 0..1, or the picture has no pixel.
  void make(int width, int height, float part_of_light);

  /// The cells of the finest level that the pixels of a tile are averaged into: those that its glow comes from, too.
  CellArea cells(const Area& tile) const;
};

}  // namespace motes::image
