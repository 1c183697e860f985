// The working memory of one tile.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/grid.h"

namespace motes::image {

/// The sum that represents a linear value of 1: a record of full colour and alpha (4064) times a weight of 255. A sum
/// holds 4144 such records; beyond that it saturates.
inline constexpr std::uint32_t kUnit = 4064 * 255;

/// Greatest sum of the scenery: the greatest float below 2^32.
inline constexpr float kMostScenery = 4294967040.0f;

/// Width, px, of the margin around a tile, into which footprints extend and whole vectors are written. Light in the
/// margin is discarded: the neighbouring tile has its own copy of the record.
inline constexpr int kMargin = kMaxFootprint - 1;
inline constexpr int kTileRows = kTile + 2 * kMargin;

/// Numbers per row of a plane: of sums, three per pixel (red, green, blue), and of values, one per pixel.
inline constexpr int kLightStride = 3 * (kTile + 2 * kMargin) + 4;
inline constexpr int kPixelStride = kTile + 2 * kMargin + 4;

/// Blocks of 8x8 pixels, for which ranges of depths are kept: per row of a tile.
inline constexpr int kBlockBits = 3, kBlocks = kTile >> kBlockBits;

/// Numbers per row of the planes of a tile's surfaces, which include the adjacent pixels around it.
inline constexpr int kSurfaceStride = kTile + 2;

/// Index of the tile's first pixel in a plane, and numbers per plane.
inline constexpr int kFirstLight = kMargin * kLightStride + 3 * kMargin;
inline constexpr int kFirstPixel = kMargin * kPixelStride + kMargin;
inline constexpr std::size_t kLightNumbers = static_cast<std::size_t>(kTileRows) * kLightStride + 64;
inline constexpr std::size_t kPixelNumbers = static_cast<std::size_t>(kTileRows) * kPixelStride + 64;

/// The nearest opaque particle at a pixel: bits of its depth, then its surface: shade, blue, green, red, each 0..255
/// (from the upper half to the lowest byte). The least number is the nearest; among equal depths the least surface
/// wins, so the result does not depend on the order of particles. Surfaces brighter than white have a shade of 0:
///
///   0 (8 bits) | exponent (4) | red (7) | green (7) | blue (6)
///
/// Their light is 2^exponent times each colour's fraction of its greatest number; the exponent is at least 1.
using NearestSurface = std::uint64_t;
inline constexpr int kBrightExponent = 20, kBrightRed = 13, kBrightGreen = 6, kMostBright = 12;
/// Returns the value for a pixel with a solid at this depth and no particle in front of it: greater than any surface at
/// that depth, less than any behind it.
constexpr NearestSurface no_surface(std::uint32_t depth) { return (NearestSurface{depth} + 1) << 32; }

/// A range of depths, as bits of floats.
struct DepthRange {
  std::uint32_t nearest, farthest;
};

/// The planes of a tile; `light`, `depth` and `surfaces` point to its first pixel.
struct TilePlanes {
  std::uint32_t* light;  // sums

  /// Bits of the depth of the nearest solid or opaque particle; infinite where there is none. Particles farther away
  /// are hidden, those at an equal depth are not.
  std::uint32_t* depth;

  NearestSurface* surfaces;

  /// Whether anything in the tile hides what is behind it. If not, `depth` is not in use.
  bool hides;
  /// The least and greatest depth in the tile. A particle in front of both or behind both needs no test per pixel.
  std::uint32_t nearest, farthest;

  /// Bounds per block on the depths that footprints of the records being drawn may meet (see DepthBlocks::met). For
  /// additive records, valid if `hides`; for opaque ones, null while not yet measured.
  const float* blocks;
};

}  // namespace motes::image
