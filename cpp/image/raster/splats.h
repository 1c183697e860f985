// What kernels need to draw the records of one sprite in one tile: what all need, and what those of one kind need.
#pragma once

#include <cstdint>

#include "image/exposures.h"
#include "image/grid.h"
#include "image/layout.h"
#include "image/light/image_levels.h"
#include "image/light/surface_light.h"
#include "image/light/texture.h"
#include "image/raster/stamps.h"

namespace motes::image {

/// What kernels need to read records, whatever they draw.
struct RecordSplat {
  int origin_x,
      origin_y;  // place of the tile's first pixel, relative to the centre of the image, in units of positions
  int record_bytes;
  RecordForm form;
  std::uint32_t color;  // of all records, if they carry none
  bool saturating;      // sums may overflow and must saturate
  float fade;           // 1 / softness, 1/m; 0: no softness
};

/// The nearest opaque particles of a tile at each exposure: planes as TilePlanes::surfaces.
struct ExposedTile {
  NearestSurface* surfaces[kExposures];
  const Exposures* exposures;
  float focus, blur;  // focus distance, m, and blur radius at infinity, px; 0: all is sharp
};

/// What a painter keeps from record to record.
struct PainterMemory {
  Stamp* stamps;             // kStamps entries, filled by the kernels; null: none
  ImageStamp* image_stamps;  // kImageStamps entries, filled by the kernels; null: none
  Cover* cover;              // accumulates weights of streaks of its colour; null: none
  const ExposedTile* exposed;  // where exposures are drawn; null: sharp surfaces are
  const Exposure* moments;  // the phases of the one exposure in which something blended is drawn; null: all of them
};

/// Parameters for drawing the wide records of one sprite. Positions are in 1/256 px, those of a pixel's centre.
struct WideSplat : RecordSplat {
  int columns, rows;  // of the tile
  int bits;           // fractional bits of records' positions
  float radius;       // radius of one pixel at a depth of 1 m, m
  PainterMemory memory;
  const SurfaceLight* light;  // applied to each point of the sprites; null: none
  const void* kind;  // the splat of the sprite's kind, below

  /// Returns what only kernels of one kind need; each names the type that Brush makes for its kind.
  template <class OfKind>
  __attribute__((always_inline)) const OfKind& own() const {
    return *static_cast<const OfKind*>(kind);
  }
};

struct DiscSplat {
  bool one_size;  // all sprites have the same size
  int key_shift;  // right shift of the size in a stamp's key: 1 for points, 0 otherwise
  /// Factor on their light at a diameter of n px that makes it equal to a footprint's; the last one applies to all
  /// larger diameters.
  float gain[kMaxFootprint + 1];
};

/// Sun and sky on a surface, from Daylight.
struct SurfaceSplat {
  float toward_sun[3], upward[3], sun, low, high;
};

/// The levels of a picture's tiles.
struct PictureSplat {
  const ImageLevel* levels;  // `level_count` per tile
  int level_count, tiles;
  const float* cover;  // by tile: mean alpha of the square around it
};

/// A camera that sees sprites in space.
struct SpaceSplat {
  float focal, near;  // focal length, px, and near plane, m
  float focus, blur;  // focus distance, m, and blur radius at infinity, px; 0: all is sharp
};

/// A sphere: its surface, and the camera if it is blended.
struct SphereSplat : SpaceSplat {
  SurfaceSplat surface;
};

struct CardSplat : SpaceSplat {
  PictureSplat picture;
};

struct MeshSplat : SpaceSplat {
  SurfaceSplat surface;
  const float *corners, *colors, *normals, *uv;  // see MeshCorners; null: they have none
  Texture picture;  // on the mesh, at `uv`; no levels: none
  int triangles, room;
  bool closed;
  float reach;  // from its origin, m
};

using PointSplat = DiscSplat;
using ImageSplat = PictureSplat;
using RibbonSplat = SpaceSplat;
using LiquidSplat = DiscSplat;

}  // namespace motes::image
