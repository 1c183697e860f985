// Hides particles just behind a surface. Solids hide particles only from a small distance behind their surface on, so
// discs resting on it are drawn whole; particles on the far side must not show through because of that.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/raster/pieces.h"
#include "image/raster/splat_lanes.h"
#include "image/raycast/scenery.h"

namespace motes::image {

/// Corrects the depths of one tile's records before they are drawn.
class Behind {
 public:
  /// Starts a tile. Its scenery must have been rendered, and must not change.
  void start(const Scenery& scenery, const Area& area, const SplatLanes& lanes);

  /// Returns the piece, or a copy (valid until the next call) in which records whose centre is behind the surface at
  /// their nearest pixel are so deep that the surface hides them completely.
  Piece settled(const Piece& piece);

  /// Returns what a kernel needs to settle records by itself, or null: none will change. Valid until the next call.
  const Settling* settling(const Brush& brush);

 private:
  void measure_blocks();

  const Scenery* scenery_ = nullptr;
  Area area_;
  const SplatLanes* lanes_ = nullptr;
  SurfaceBlock blocks_[kBlocks][kBlocks];
  Settling settling_;
  BufferOf<std::uint32_t> numbers_, depths_;
  Buffer records_;
};

}  // namespace motes::image
