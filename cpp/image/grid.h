// The tiles of an image, and the fixed-point positions of particles in it.
#pragma once

#include <cstdint>

namespace motes::image {

/// Side of a tile in pixels: its accumulator (64x64 pixels, three sums of 32 bits) stays in the second-level cache.
inline constexpr int kTile = 64;
inline constexpr int kTileBits = 6;

/// Largest width and height, px: coordinates and the numbers of 65536 tiles fit into 16 bits.
inline constexpr int kMaxSize = 16384;

/// Largest footprint of a particle of fixed size, px; it touches at most 2x2 tiles.
inline constexpr int kMaxFootprint = 15;

/// A tile's number and its pixels; tiles at the right and lower edge of the image may be smaller than kTile.
struct Area {
  int tile = 0;
  int x = 0, y = 0;  // first pixel, from the top left corner of the image
  int width = 0, height = 0;
};

struct Grid {
  int width = 0;
  int height = 0;

  constexpr int columns() const { return (width + kTile - 1) >> kTileBits; }
  constexpr int rows() const { return (height + kTile - 1) >> kTileBits; }
  constexpr int tiles() const { return columns() * rows(); }

  constexpr Area area(int tile) const {
    const int x = tile % columns() * kTile, y = tile / columns() * kTile;
    return {tile, x, y, width - x < kTile ? width - x : kTile, height - y < kTile ? height - y : kTile};
  }

  /// Returns the fractional bits of positions (see sub_bits) of sprites of any size and of streaks, which may begin up
  /// to 370 px outside the image; 0 if the image is too large for 16-bit positions.
  constexpr int far_bits() const {
    const int longer = width > height ? width : height;
    return longer <= 3328 ? 4 : longer <= 7424 ? 3 : 0;
  }

  /// Returns the fractional bits of positions, which are 16-bit integers relative to the centre of the image: in 1/16
  /// px up to 4064 px, 1/8 px up to 8160, and so on. A margin of 16 px is for footprints that extend into the image.
  constexpr int sub_bits() const {
    const int longer = width > height ? width : height;
    return longer <= 4064 ? 4 : longer <= 8160 ? 3 : longer <= 16352 ? 2 : 1;
  }
};

}  // namespace motes::image
