// Turns wide records into light: sprites of any size up to kMaxDiameter, streaks and images, computed pixel by pixel.
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

/// Greatest light in the middle of a normalised sprite, relative to that of a footprint.
inline constexpr float kMostLight = 1.125f;

/// Parameters for drawing the wide records of one sprite in one tile.
struct WideSplat {
  int origin_x, origin_y;  // centre of the tile's first pixel, relative to the centre of the image, 1/256 px
  int columns, rows;       // of the tile
  int record_bytes;
  RecordForm form; // of the records
  std::uint32_t color;  // of all records, if they carry none
  int bits;        // fractional bits of records' positions
  bool saturating; // sums may overflow and must saturate
  float fade;      // 1 / softness, 1/m; 0: no softness
  float radius; // radius of one pixel at a depth of 1 m, m

  /// Discs and points: factor on their light at a diameter of n px that makes it equal to a footprint's; the last one
  /// applies to all larger diameters.
  float gain[kMaxFootprint + 1];

  /// Spheres: their lighting, from Daylight.
  float toward_sun[3], upward[3], sun, low, high, mean_shade;

  bool one_size;  // all sprites have the same size
  int key_shift;  // right shift of the size in a stamp's key: 1 for points, 0 otherwise
  Stamp* stamps;  // kStamps entries, filled by the kernels
  Cover* cover;  // accumulates weights of streaks of its colour; null: none

  const ImageLevel* levels;  // images: `level_count` levels per tile
  int level_count, tiles;
  ImageStamp* image_stamps;  // kImageStamps entries, filled by the kernels; null: none
  const float* image_cover;  // by tile: mean alpha of the square around it

  float focal, near;  // sprites in space: focal length of the camera, px, and its near plane, m
  float focus, blur;  // sprites in space: focus distance, m, and blur radius at infinity, px; 0: all is sharp
  const float *corners, *colors;  // meshes: see MeshCorners; null: they have no colours
  int triangles, room;
  bool closed;
  float mesh_reach;  // from its origin, m
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
#include "image/sprites/list.inc"
#include "simd/declare_builds.h"
  return kinds;
}();

struct WideLanes {
  WideKernels kinds[kSpriteKinds];  // by Sprite::Kind

  /// Adds the accumulated weights of `rows` rows to the tile's light and clears the Cover.
  void (*show_cover)(const TilePlanes& tile, Cover& cover, int rows);
};

/// Returns the build for this processor.
const WideLanes& wide_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::WideLanes, wide_lanes)
