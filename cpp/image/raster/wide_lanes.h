// Turns wide records into light: sprites of any size up to kMostDiameter, streaks and images, computed pixel by pixel.
#pragma once

#include <cstddef>
#include <variant>

#include "image/raster/splats.h"
#include "image/sprites/sprite.h"
#include "image/tile_planes.h"
#include "simd/declare_builds.h"

namespace motes::image {

/// Greatest light in the middle of a normalised sprite, relative to that of a footprint.
inline constexpr float kMostLight = 1.125f;

/// Draws `count` wide records.
using WideKernel = void(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count);

struct WideKernels {
  WideKernel* add;
  WideKernel* over;
  WideKernel* opaque;
  WideKernel* exposed;  // opaque, at each exposure: see ExposedTile
};

struct WideLanes {
  WideKernels kinds[std::variant_size_v<AnyLook>];  // by Sprite::Kind

  /// Adds the accumulated weights of `rows` rows to the tile's light and clears the Cover.
  void (*show_cover)(const TilePlanes& tile, Cover& cover, int rows);
};

/// Returns the build for this processor.
const WideLanes& wide_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::WideLanes, wide_lanes)
