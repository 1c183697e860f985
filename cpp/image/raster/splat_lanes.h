// Records to light: the inner loops of a tile's painter. Records of one fixed size, up to kMaxFootprint pixels.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/layout.h"
#include "image/raster/depth_bands.h"
#include "image/tile_planes.h"
#include "image/tone.h"
#include "simd/declare_builds.h"

namespace motes::image {

/// Pixels per row in the tables of opaque sprites of this size.
constexpr int surface_row(int size) { return size <= 8 ? 8 : 16; }

/// Where a surface has its shade, 0..255: see Nearest.
inline constexpr int kShadeShift = 24;

/// How records of one sprite find their pixels. Rows of a sub-pixel phase follow one another, see Footprint.
struct Splat {
  const std::uint8_t* weights;  // of light, three per pixel
  const std::uint8_t* cover;  // of what is covered, three per pixel: for alpha; the same table where both are equal
  const std::uint16_t* covered;  // opaque: bit c of a row is set where it covers column c
  const std::uint32_t* shade;  // opaque: surface_row(size) per row, shifted by kShadeShift; null: fully lit
  const float* bulge;  // opaque, as `shade`: how much nearer than its centre the particle is, in radii; null: flat
  float radius;  // of the particle at a depth of 1 m, m
  int size, phase_bits, row_bytes;
  int sub_bits;
  int record_bytes;
  RecordForm form;      // of the records
  std::uint32_t color;  // of all of them, where they have none
  int origin_x, origin_y;  // fixed-point position of the particle whose footprint starts at the tile's first pixel
  bool saturating;  // the sums may overflow
  float fade;  // 1 / softness, 1/m; 0: hard
};

/// Draws `count` records.
using SplatKernel = void(const TilePlanes& tile, const Splat& splat, const unsigned char* records, std::size_t count);

struct SplatLanes {
  SplatKernel* add;
  SplatKernel* over;  // far to near, in the order of the records
  SplatKernel* opaque;  // the nearest wins; see Nearest

  /// For each block of the tile (see DepthBlocks), row by row, the bits of the greatest depth in tile.surfaces; 0
  /// where none of them is in the rows and columns of the tile.
  void (*measure_surfaces)(const TilePlanes& tile, int rows, int columns, std::uint32_t* farthest);

  /// Gives opaque particles their light, wherever tile.surfaces is nearer than tile.depth, and their depth. Returns the
  /// range of tile.depth.
  DepthRange (*show_surfaces)(const TilePlanes& tile, int rows, int columns);

  /// The greatest of the sums in `rows` rows of `lanes` lanes.
  std::uint32_t (*brightest)(const std::uint32_t* light, int rows, int lanes);

  /// to[i] = table[index of light[i]]: the index has 2^kToneBits steps per octave of light[i] / 2.
  void (*tone)(const std::uint32_t* light, std::size_t count, const std::uint8_t* table, std::uint8_t* to);

  /// Lists the records that are in their bands; returns how many. `numbers` has room for `count` and a vector.
  std::size_t (*find_in_bands)(const BandSearch& search, const unsigned char* records, std::size_t count,
                               std::uint32_t* numbers);
};

/// The build that suits this processor.
const SplatLanes& splat_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::SplatLanes, splat_lanes)
