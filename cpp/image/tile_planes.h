// The working memory of one tile.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/grid.h"

namespace motes::image {

/// The sum that represents a linear value of 1: a record of full colour and alpha (4064) times a weight of 255. A sum
/// holds 4144 such records; with more it stays at its greatest value.
inline constexpr std::uint32_t kUnit = 4064 * 255;

/// The greatest sum that the scenery has: the greatest float below 2^32.
inline constexpr float kMostScenery = 4294967040.0f;

/// Footprints extend over a tile's edges by less than the largest footprint; vectors are read and written whole. What
/// falls into this margin is not read: the neighbouring tile has its own copy of the record.
inline constexpr int kMargin = kMaxFootprint - 1;
inline constexpr int kTileRows = kTile + 2 * kMargin;

/// From row to row: sums, three per pixel (red, green, blue); and values, one per pixel.
inline constexpr int kLightStride = 3 * (kTile + 2 * kMargin) + 4;
inline constexpr int kPixelStride = kTile + 2 * kMargin + 4;

/// From the start of a plane to the tile's first pixel, and the numbers that a plane has.
inline constexpr int kFirstLight = kMargin * kLightStride + 3 * kMargin;
inline constexpr int kFirstPixel = kMargin * kPixelStride + kMargin;
inline constexpr std::size_t kLightNumbers = static_cast<std::size_t>(kTileRows) * kLightStride + 64;
inline constexpr std::size_t kPixelNumbers = static_cast<std::size_t>(kTileRows) * kPixelStride + 64;

/// The nearest opaque particle at a pixel: bits of its depth, then its surface: shade, blue, green, red, each 0..255
/// (from the upper half to the lowest byte). The least number is the nearest; of equally near ones it is that with the
/// least surface, so that it does not depend on their order.
using NearestSurface = std::uint64_t;
/// No particle in front of a solid at this depth: more than any surface there, less than any behind it.
constexpr NearestSurface no_surface(std::uint32_t depth) { return (NearestSurface{depth} + 1) << 32; }

/// Bits of depths.
struct DepthRange {
  std::uint32_t nearest, farthest;
};

/// Each pointer is to the tile's first pixel.
struct TilePlanes {
  std::uint32_t* light;  // sums

  /// Bits of the depth of the nearest solid or opaque particle. What is farther away is hidden; at an equal depth it is
  /// not. Infinite where there is nothing.
  std::uint32_t* depth;

  NearestSurface* surfaces;

  /// Where nothing hides anything, `depth` is not in use.
  bool hides;
  /// The least and greatest depth in the tile: a particle in front of or behind both needs no test per pixel.
  std::uint32_t nearest, farthest;

  /// What footprints of the records being drawn meet, and what is not farther away (see DepthBlocks): of those that are
  /// added, where something hides; of opaque ones, null where it is not known.
  const float* blocks;
};

}  // namespace motes::image
