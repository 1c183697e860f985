// Particles just behind a surface. Scenery begins to hide a little behind its surface, so that what rests on it shows,
// down to the pixels of a disc that reach below its centre. What is on the other side must not show through for that.
#pragma once

#include <cstddef>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/raster/pieces.h"
#include "image/raycast/scenery.h"

namespace motes::image {

/// Looks at the records of one tile before they are drawn.
class Behind {
 public:
  /// The scenery of this tile must have been rendered, and stay.
  void start(const Scenery& scenery, const Area& area);

  /// Returns the piece, or a copy that is valid until the next call, in which records of particles whose centre is
  /// behind the surface that their nearest pixel shows are so deep that this surface hides all of them.
  Piece settled(const Piece& piece);

 private:
  // Where a record's centre is, pixels from the image's top left corner, and its size.
  struct Center {
    float x, y;
    float blur;    // how far it may be from there
    float radius;  // pixels
  };
  Center center_of(const Piece& piece, const std::byte* record) const;
  float settled_depth(const Center& center, float depth) const;
  float bend(int column, int row) const;

  const Scenery* scenery_ = nullptr;
  Area area_;
  float least_ = 0;  // no surface is nearer
  Buffer records_;
};

}  // namespace motes::image
