// Depth ranges of a tile in blocks of pixels. Most particles are in front of everything near them, or behind it, and
// need no test per pixel.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/grid.h"
#include "image/raster/splat_lanes.h"
#include "image/tile_planes.h"

namespace motes::image {

/// Nearest and farthest depth per block of 8x8 pixels.
class DepthBlocks {
 public:
  static constexpr int kBits = kBlockBits;
  /// Pixels by which a footprint may begin outside the tile.
  static constexpr int kBefore = 2 << kBits;
  /// Blocks per row.
  static constexpr int kSide = (kBefore + kTile) >> kBits;
  static_assert(kBefore >= kMargin);

  /// Returns the block in which a footprint at this pixel begins: 0 .. kSide * kSide - 1.
  template <class Number>
  static constexpr Number at(Number column, Number row) {
    return ((row + kBefore) >> kBits) * kSide + ((column + kBefore) >> kBits);
  }

  /// Drops the ranges, because the tile's depths have changed.
  void forget() { measured_ = false; }

  /// Measures tile.surfaces instead of tile.depth. All ranges begin at 0, so they stay valid when surfaces come nearer.
  void measure_surfaces(const TilePlanes& tile, const Area& area, const SplatLanes& lanes);

  /// Returns two numbers per block: bounds on the nearest and farthest depth that a footprint of `size` pixels
  /// beginning there may meet. Only the size of `area` matters. The tile must have depths. `blocks`: their lower
  /// bounds count, too, kTile / 8 rows of as many, the same until forget(); null: none.
  const float* met(const TilePlanes& tile, const Area& area, int size, const SurfaceBlock* blocks = nullptr);

 private:
  // Greatest number of blocks that a footprint extends to the right and down.
  static constexpr int kReach = (kMargin + (1 << kBits) - 1) >> kBits;

  void clear();
  void measure(const TilePlanes& tile, const Area& area, const SurfaceBlock* blocks);
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
