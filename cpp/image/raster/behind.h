// Hides particles just behind a surface. Scenery hides only what is a little behind its surface, so that discs resting
// on it show whole; particles on the other side must not show through because of that.
#pragma once

#include <cstddef>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/raster/pieces.h"
#include "image/raycast/scenery.h"

namespace motes::image {

/// Corrects the depths of one tile's records before they are drawn.
class Behind {
 public:
  /// Starts a tile, whose scenery must have been rendered and must not change.
  void start(const Scenery& scenery, const Area& area);

  /// Returns the piece, or a copy (valid until the next call) in which records whose centre is behind the surface at
  /// their nearest pixel are so deep that the surface hides them completely.
  Piece settled(const Piece& piece);

 private:
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
  float least_ = 0;  // lower bound on the depth of surfaces, m
  Buffer records_;
};

}  // namespace motes::image
