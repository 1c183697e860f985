// Wide records to light: sprites of any size up to kMaxDiameter, streaks and images, computed pixel by pixel.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/grid.h"
#include "image/layout.h"
#include "image/raster/cover.h"
#include "image/raster/image_levels.h"
#include "image/raster/stamps.h"
#include "image/tile_planes.h"

namespace motes::image {

/// A normalised sprite may be brighter in its middle than a footprint by this factor.
inline constexpr float kMostLight = 1.125f;

/// How wide records of one sprite find their pixels.
struct WideSplat {
  int origin_x, origin_y;  // 1/256 px: middle of the tile's first pixel, from the centre of the image
  int columns, rows;       // of the tile
  int record_bytes;
  RecordForm form; // of the records
  std::uint32_t color;  // of all of them, where they have none
  int bits;        // of their positions
  bool saturating; // the sums may overflow
  float fade;      // 1 / softness, 1/m; 0: hard
  float radius; // of something with a radius of one pixel at a depth of 1 m, m

  /// Discs and points: what their light is multiplied by at a diameter of n pixels, so that it is that of a footprint
  /// of this size; the last one holds for all larger ones.
  float gain[kMaxFootprint + 1];

  /// Spheres: see Daylight.
  float toward_sun[3], upward[3], sun, low, high, mean_shade;

  bool one_size;  // all sprites are equally large
  int key_shift;  // of sizes in keys of stamps; 1 for points: see Stamp
  Stamp* stamps;  // kStamps of them, which the kernels fill
  Cover* cover;  // where the light of its colour's streaks is added up; null: nowhere

  const ImageLevel* levels;  // images
  int level_count;
  float image_cover;  // the part of a square around the picture that it covers
};

/// Draws `count` wide records.
using WideKernel = void(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count);

struct WideKernels {
  WideKernel* add;
  WideKernel* over;
  WideKernel* opaque;
};

inline constexpr int kSpriteKinds = [] {
  int kinds = 0;
#define MOTES_SPRITE_KIND(kind, Name) ++kinds;
#include "image/raster/kinds.inc"
#include "simd/declare_builds.h"
  return kinds;
}();

struct WideLanes {
  WideKernels kinds[kSpriteKinds];  // by Sprite::Kind

  /// Adds what is covered to the light of `rows` rows, and clears it.
  void (*show_cover)(const TilePlanes& tile, Cover& cover, int rows);
};

/// The build that suits this processor.
const WideLanes& wide_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::WideLanes, wide_lanes)
