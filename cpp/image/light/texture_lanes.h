// Pictures on meshes, at their places. Compiled once for each instruction set.
#pragma once

#include "image/light/sky_lanes.h"

namespace motes::MOTES_ISA {

/// Returns the largest level of a texture with at most 1.5 texels per pixel; `texels`: per pixel in the first level.
inline int level_for(const image::Texture& all, float texels) {
  int level = 0;
  for (; texels > 1.5f && level + 1 < all.count; ++level) texels *= 0.5f;
  return level;
}

/// Returns the place at x, repeating from 0 to 1, in pixels.
inline float repeated(float x, int pixels) { return (x - __builtin_floorf(x)) * static_cast<float>(pixels); }

/// Returns the level of a picture to show on a triangle. `uv`: the places of its corners; `area`: twice its area, m^2;
/// `footprint`: width of a pixel there, m.
inline int level_on_mesh(const image::Texture& all, const float* uv, float area, float footprint) {
  const float texels = (uv[2] - uv[0]) * (uv[5] - uv[1]) - (uv[4] - uv[0]) * (uv[3] - uv[1]);
  const float pixels = static_cast<float>(all.levels[0].width) * static_cast<float>(all.levels[0].height);
  const float square = __builtin_fabsf(texels) * pixels / (area + 1e-30f);  // per m^2
  return level_for(all, footprint * __builtin_sqrtf(square));
}

/// Returns the light of a level at a point of a triangle. `parts`: of its corners in the point.
inline Float3 light_on_mesh(const image::TextureLevel& level, const float* uv, Float3 parts) {
  const float u = uv[0] * parts.x + uv[2] * parts.y + uv[4] * parts.z;
  const float v = uv[1] * parts.x + uv[3] * parts.y + uv[5] * parts.z;
  return texel_mix(level, repeated(u, level.width), repeated(1 - v, level.height), true);
}

}  // namespace motes::MOTES_ISA
