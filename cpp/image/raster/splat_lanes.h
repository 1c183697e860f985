// Turns records of one fixed size, up to kMaxFootprint pixels, into light: the inner loops of a tile's painter.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/balls/ball_tile.h"
#include "image/layout.h"
#include "image/raster/splats.h"
#include "image/tile_planes.h"
#include "image/tone.h"
#include "simd/declare_builds.h"

namespace motes::image {

/// What is known of the surfaces in a block of a tile.
struct SurfaceBlock {
  float low, high;  // range of depths for which the visibility of flat particles needs a closer test, m
  float bias;       // greatest distance between a surface and the depth from which on it hides particles, m
  float slope;      // greatest relative change of depth per pixel, but for steep pixels
};

/// What settles the records of one brush in a tile with surfaces: see Behind. A centre's column is
/// (2 * position + first_column) >> shift, within 0..last_column.
struct Settling {
  Layout layout;
  RecordForm form;
  int record_bytes;
  int shift, first_column, first_row;
  int last_column, last_row;
  float radius;  // of records of fixed size, px
  float blur;    // error of positions, px
  bool flat;     // the particle is nowhere nearer than its centre

  const SurfaceBlock* blocks;  // kBlocks rows of kBlocks; records larger than often_radius, px, have low and high
  float often_radius, low, high;
  const std::uint32_t* hides;  // bits of depths from which on surfaces hide particles, kTile rows of kTile
  const std::uint32_t* steep;  // two words per row, whose bits are set for steep pixels

  // Planes of the surfaces' depths, m, the components of their normals, and their numbers (see Surfaces): rows of
  // kSurfaceStride; `plane`: from one to the next.
  const float* surfaces;
  std::ptrdiff_t plane;

  // The camera's axes, the side of a pixel at a depth of 1 m, m, and the middle of the tile's first pixel, px from that
  // of the image.
  float right[3], up[3], forward[3];
  float pixel, left, top;
};

/// Returns the pixels per row in tables of opaque sprites of this size.
constexpr int surface_row(int size) { return size <= 8 ? 8 : 16; }

/// Bit position of the shade, 0..255, in a surface (see Nearest).
inline constexpr int kShadeShift = 24;

/// Parameters for drawing the records of one sprite of fixed size. Rows of tables are ordered as in Footprint. The
/// origin is the position of the particle whose footprint starts at the tile's first pixel.
struct Splat : RecordSplat {
  BallTile* balls;  // light of spheres in this tile; null: the sprites are flat
  const std::uint8_t* weights;  // three per pixel: of light and cover; of spheres: of cover only
  // Of opaque sprites.
  const std::uint16_t* covered;  // bit c of a row is set if it covers column c
  const float* bulge;  // surface_row(size) per row: how much nearer than its centre a sphere is, in radii; null: flat
  float radius;  // radius of a particle at a depth of 1 m, m
  int size, phase_bits, row_bytes;
  int sub_bits;
  float fog[3], fog_density;  // in front of opaque spheres, 1/m; 0: none
  float per_unit;  // 1 / focal length, in units of positions
  const Settling* settling;  // of additive records that are not settled yet; null: none
};

/// Draws `count` records.
using SplatKernel = void(const TilePlanes& tile, const Splat& splat, const unsigned char* records, std::size_t count);

struct SplatLanes {
  SplatKernel* add;
  SplatKernel* over;  // blends by alpha in the order of the records: far to near
  SplatKernel* opaque;  // keeps the nearest surface per pixel

  /// Writes, for each block of the tile (see DepthBlocks), the bits of the greatest depth in tile.surfaces; 0 for
  /// blocks outside the given rows and columns.
  void (*measure_surfaces)(const TilePlanes& tile, int rows, int columns, std::uint32_t* farthest);

  /// Copies light and depth of opaque particles to the tile where tile.surfaces is nearer than tile.depth. Returns the
  /// range of tile.depth.
  DepthRange (*show_surfaces)(const TilePlanes& tile, int rows, int columns);

  /// Returns the greatest sum in `rows` rows of `lanes` lanes.
  std::uint32_t (*brightest)(const std::uint32_t* light, int rows, int lanes);

  /// Dithers sums of light, three per pixel, from column x of row y of the picture on. Values are
  /// table[index of light[i]]; the index has 2^kToneBits steps per octave of light[i] / 2.
  void (*tone)(const std::uint32_t* light, std::size_t count, int x, int y, const std::uint16_t* table,
               std::uint8_t* to);

  /// Writes the numbers of the records that become deeper, and the bits of their depths; returns how many they are.
  /// Both arrays have room for `count` plus a vector.
  std::size_t (*settle)(const Settling& settling, const unsigned char* records, std::size_t count,
                        std::uint32_t* numbers, std::uint32_t* depths);
};

/// Returns the build for this processor.
const SplatLanes& splat_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::SplatLanes, splat_lanes)
