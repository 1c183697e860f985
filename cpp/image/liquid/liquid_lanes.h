// The inner loops of liquids, on rows of pixels. Planes hold one number per pixel; depths are view depths, m, infinite
// where there is no liquid.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/light/sky.h"
#include "image/light/surface_light.h"
#include "simd/declare_builds.h"

namespace motes::image {

/// Thickness of liquids: units per diameter of a particle.
inline constexpr int kThickness = 256;

/// A particle in a row of a tile.
struct BallRow {
  float x;         // its centre, px from the row's first pixel
  float per_px;    // 1 / its radius, px
  float rest;      // 1 - (distance of the row from the centre in radii)^2
  float depth, radius;  // of its centre, m
};

/// What a row of pixels needs to be shaded. Pointers are to its first pixel; depths are readable one pixel beyond both
/// ends.
struct LiquidRow {
  const float *depth, *above, *below;  // of the liquid, and in the adjacent rows
  const float* opaque;                 // of what is not liquid; infinite where there is nothing
  const std::uint32_t* thickness;
  const float *red, *green, *blue, *alpha;  // means over particles, 0..1
  const float* speed;  // in speeds of white foam
  std::uint32_t* light;  // three sums per pixel
  int y, first, count;   // the row, the first pixel's column, pixels
};

/// A liquid and the picture behind it.
struct LiquidLook {
  const SurfaceLight* light;
  float per_px;             // 1 / focal length, px
  float center_x, center_y;  // of the picture, px
  float metres;             // of a unit of thickness
  float radius;             // of particles, m
  float bend;       // 1 - 1 / index of refraction
  float reflected;  // light from the front that it reflects
  float per_foam;   // 1 / speed of white foam; 0: no foam
  // The picture behind: sums of light and depths.
  const std::uint32_t* behind;
  const float* opaque;
  std::ptrdiff_t opaque_row;  // numbers per row
  int width, height;
};

struct LiquidLanes {
  /// depth[i] = the least of it and the ball's, thickness[i] += the ball's, for a row of `count` pixels.
  void (*splat)(const BallRow& ball, float* depth, std::uint32_t* thickness, int count);

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
