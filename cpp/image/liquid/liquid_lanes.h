// The inner loops of liquids, on rows of pixels. Planes hold one number per pixel; depths are view depths, m, infinite
// where there is no liquid.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/grid.h"
#include "image/light/sky.h"
#include "image/light/surface_light.h"
#include "simd/declare_builds.h"

namespace motes::image {

/// Thickness of liquids: units per diameter of a particle.
inline constexpr int kThickness = 256;

/// Side of the cells for means, px; a tile has whole ones, but at the edge of the picture.
inline constexpr int kLiquidCell = 8;
inline constexpr int kTileCells = kTile / kLiquidCell;

/// What is averaged over particles in cells: sums of these, each times the part of a particle that is in the cell.
struct LiquidMean {
  enum { red, green, blue, alpha, speed, weight, count };
  static constexpr int kRoom = 8;  // numbers per cell, so that a vector holds a cell
};

/// A particle: its centre, px from the tile's first pixel; its radius, px; the view depth of its centre, m.
struct LiquidBall {
  float x, y, radius, depth;
  std::uint32_t values[LiquidMean::kRoom];  // at most 2^24 each
};

/// The planes of a tile while particles are added. Rows are kRow numbers apart: whole vectors are written.
struct LiquidTile {
  static constexpr int kRow = kTile + 16;

  int width, height;
  float radius;  // of particles, m
  float depth[kRow * kTile];
  std::uint32_t thickness[kRow * kTile];
  std::uint64_t cells[kTileCells * kTileCells * LiquidMean::kRoom];
};

/// What a row of pixels needs to be shaded. Pointers are to its first pixel; depths are readable one pixel beyond both
/// ends.
struct LiquidRow {
  const float *depth, *above, *below;  // of the liquid, and in the adjacent rows
  const float* opaque;                 // of what is not liquid; infinite where there is nothing
  const std::uint32_t* thickness;
  const float* sums[LiquidMean::count];  // in the picture's cells, at the height of this row; the last one twice
  int cells;                             // of a row of the picture
  std::uint32_t* light;                  // three sums per pixel
  int y, first, count;                   // the row, the first pixel's column, pixels
};

/// The farthest that a liquid shifts what is behind it, in heights of the picture.
inline constexpr float kMostShift = 0.05f;

/// A liquid and the picture behind it.
struct LiquidLook {
  const SurfaceLight* light;
  float per_px;             // 1 / focal length, px
  float center_x, center_y;  // of the picture, px
  float metres;             // of a unit of thickness
  float radius;             // of particles, m
  float bend;       // 1 - 1 / index of refraction
  float reflected;  // light from the front that it reflects
  float per_foam;   // 1 / speed of white foam, in units of speeds; 0: no foam
  // The picture behind: sums of light and depths.
  const std::uint32_t* behind;
  const float* opaque;
  std::ptrdiff_t opaque_row;  // numbers per row
  int width, height;
};

struct LiquidLanes {
  /// Adds balls to the least depths, the thickness and the sums of a tile.
  void (*splat)(LiquidTile& tile, const LiquidBall* balls, std::size_t count);

  /// to[i] = at[i] + (4 (near pair - 2 at) + (far pair - 2 at)) / 16: the binomial filter, without pairs that are
  /// farther than `jump` from the middle, and only where depths are at most `farthest`. Pairs are at -1, 1, -2 and 2
  /// strides.
  void (*smooth)(float* to, const float* at, const float* const (&pairs)[4], float jump, float farthest, int count);

  /// Draws the liquid over a row.
  void (*shade)(const LiquidLook& look, const LiquidRow& row);
};

/// Returns the build for this processor.
const LiquidLanes& liquid_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::LiquidLanes, liquid_lanes)
