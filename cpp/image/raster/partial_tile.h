// A tile's sums and nearest surfaces as a message: what several ranks drew of one tile is merged by its owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/tile_planes.h"

namespace motes::image {

/// A rectangle of a tile's pixels.
struct Box {
  std::uint8_t left = 0, top = 0, right = 0, bottom = 0;

  std::size_t columns() const { return static_cast<std::size_t>(right - left); }
  std::size_t pixels() const { return columns() * static_cast<std::size_t>(bottom - top); }
  bool inside(const Area& area) const {
    return left <= right && top <= bottom && right <= area.width && bottom <= area.height;
  }
};

/// Appends the smallest rectangle of pixels that have light, and the smallest with an opaque particle:
///   magic u32, tile u32, two boxes of 4 u8, sums u32[rows][columns][3], Nearest[rows][columns]
/// `surfaces`: tile.surfaces and tile.depth are in use.
void append_partial(const Area& area, const TilePlanes& tile, bool surfaces, Buffer& to);

/// Such a message in memory owned by someone else.
class PartialTile {
 public:
  /// Throws std::runtime_error where the bytes are not a whole partial tile of this area.
  PartialTile(std::span<const std::byte> bytes, const Area& area);

  bool has_surfaces() const { return surface_box_.pixels() != 0; }

  /// Adds its sums; one that would overflow gets its greatest value, so that the order of partial tiles has no meaning.
  void add_light(std::uint32_t* light) const;

  /// Keeps the nearer surfaces.
  void keep_nearest(Nearest* surfaces) const;

 private:
  std::span<const std::byte> bytes_;
  Box light_box_, surface_box_;
};

}  // namespace motes::image
