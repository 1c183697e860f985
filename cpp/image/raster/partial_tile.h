// A partial tile: sums and nearest surfaces that one rank drew, as a message to the tile's owner, which merges them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/tile_planes.h"

namespace motes::image {

/// A rectangle of a tile's pixels.
struct PixelBox {
  std::uint8_t left = 0, top = 0, right = 0, bottom = 0;

  std::size_t columns() const { return static_cast<std::size_t>(right - left); }
  std::size_t pixels() const { return columns() * static_cast<std::size_t>(bottom - top); }
  bool inside(const Area& area) const {
    return left <= right && top <= bottom && right <= area.width && bottom <= area.height;
  }
};

/// Appends to a message the bounding boxes of pixels with light and of pixels with an opaque particle:
/// magic u32, tile u32, two boxes of 4 u8, sums u32[rows][columns][3], Nearest[rows][columns].
/// `surfaces`: whether tile.surfaces and tile.depth are in use.
void append_partial(const Area& area, const TilePlanes& tile, bool surfaces, Buffer& to);

/// A view of a partial tile's message.
class PartialTile {
 public:
  /// Throws std::runtime_error if the bytes are not a whole partial tile of this area.
  PartialTile(std::span<const std::byte> bytes, const Area& area);

  bool has_surfaces() const { return surface_box_.pixels() != 0; }

  /// Adds its sums to `light`, saturating, so the order of partial tiles does not matter.
  void add_light(std::uint32_t* light) const;

  /// Keeps the nearer surface at each pixel.
  void keep_nearest(NearestSurface* surfaces) const;

 private:
  std::span<const std::byte> bytes_;
  PixelBox light_box_, surface_box_;
};

}  // namespace motes::image
