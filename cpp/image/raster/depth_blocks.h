// What a tile hides, coarsely: most particles are in front of everything near them, or behind it, and need no test per
// pixel.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/grid.h"
#include "image/raster/splat_lanes.h"
#include "image/tile_planes.h"

namespace motes::image {

/// Depths in blocks of 8x8 pixels.
class DepthBlocks {
 public:
  static constexpr int kBits = 3;
  /// Footprints begin up to so many pixels outside the tile.
  static constexpr int kBefore = 2 << kBits;
  /// Blocks per row.
  static constexpr int kSide = (kBefore + kTile) >> kBits;
  static_assert(kBefore >= kMargin);

  /// The block in which a footprint begins: 0 .. kSide * kSide - 1.
  template <class Number>
  static constexpr Number at(Number column, Number row) {
    return ((row + kBefore) >> kBits) * kSide + ((column + kBefore) >> kBits);
  }

  /// The tile's depths have changed.
  void forget() { measured_ = false; }

  /// From now on depths are those of tile.surfaces as they are now, and no range is narrower than from 0 on. Surfaces
  /// that come nearer stay within it.
  void measure_surfaces(const TilePlanes& tile, const Area& area, const SplatLanes& lanes);

  /// For each block two numbers, the least and the greatest of the depths that footprints of `size` pixels may meet
  /// that begin there, or of more. `area`: of it, only its size is looked at. The tile must have depths.
  const float* met(const TilePlanes& tile, const Area& area, int size);

 private:
  // Blocks to the right and below that footprints reach, at most.
  static constexpr int kReach = (kMargin + (1 << kBits) - 1) >> kBits;

  void clear();
  void measure(const TilePlanes& tile, const Area& area);
  void widen(int reach);

  bool measured_ = false;
  int reach_ = 0;
  struct Range {
    float nearest, farthest;
  };
  Range own_[kSide + kReach][kSide + kReach];
  float met_[kSide][kSide][2];
};

}  // namespace motes::image
