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

 private:
  void measure_bands(float radius);
  void measure_row(int row, float reach);
  std::size_t find_in_bands(const Piece& piece);
  // A record's centre, px from the image's top left corner, and its size.
  struct Center {
    float x, y;
    float blur;    // error of x and y, px
    float radius;  // pixels
  };
  Center center_of(const Piece& piece, const std::byte* record) const;
  float settled_depth(const Center& center, float depth) const;
  float bend(int column, int row) const;

  const Scenery* scenery_ = nullptr;
  Area area_;
  float least_ = 0;      // lower bound on the depth of surfaces
  float radius_ = -1;    // greatest radius for which `bands_` are valid, px
  const SplatLanes* lanes_ = nullptr;
  BufferOf<DepthBand> bands_;  // kTile rows of kTile
  BufferOf<std::uint32_t> found_;
  Buffer records_;
};

}  // namespace motes::image
