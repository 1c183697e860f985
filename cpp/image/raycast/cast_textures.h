// Textures of solids, at points of their surfaces.
#pragma once

#include "image/light/texture_lanes.h"
#include "image/raycast/cast.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Float3 lane_of(Floats3 v, std::size_t lane) { return {v.x[lane], v.y[lane], v.z[lane]}; }

/// Returns the parts, 0..1, of a triangle's corners in a point of it; both in the mesh's coordinates.
inline Float3 parts_of(const meshes::BvhTriangle& triangle, Float3 place) {
  const Float3 normal = of(triangle.normal);
  float part[3], all = 0;
  for (int k = 0; k < 3; ++k) {
    const Float3 one = minus(of(triangle.corner[(k + 1) % 3]), place);
    const Float3 other = minus(of(triangle.corner[(k + 2) % 3]), place);
    const float area = dot(normal, cross(one, other));
    part[k] = area > 0 ? area : 0;
    all += part[k];
  }
  const float per = 1 / (all > 1e-37f ? all : 1e-37f);
  return {part[0] * per, part[1] * per, part[2] * per};
}

/// Returns one of several numbers per corner of a triangle, interpolated linearly.
inline float mixed(const float* corners, std::size_t triangle, int numbers, int which, Float3 parts) {
  const float* own = corners + 3 * triangle * static_cast<std::size_t>(numbers) + which;
  return own[0] * parts.x + own[numbers] * parts.y + own[2 * numbers] * parts.z;
}

/// Returns the colour of a picture on a mesh at a point of a triangle. `footprint`: width of a pixel there, m.
inline Float3 image_on_mesh(const image::Material& material, const image::Texture& all, std::size_t number,
                            Float3 parts, float footprint) {
  const meshes::BvhTriangle& triangle = material.mesh->triangles[number];
  const float* uv = material.uv + 6 * number;
  const Float3 first = of(triangle.corner[0]);
  const Float3 across = cross(minus(of(triangle.corner[1]), first), minus(of(triangle.corner[2]), first));
  const int level = level_on_mesh(all, uv, __builtin_sqrtf(dot(across, across)), footprint);
  return light_on_mesh(all.levels[level], uv, parts);
}

/// Returns the colour of an object's image at a point of its surface. The image extends along the two axes of the
/// world, or of the mesh, that are most parallel to the surface. `footprint`: width of a pixel there, m.
inline Float3 image_light(const image::Material& material, const image::Texture& all, Float3 place, Float3 normal,
                          float footprint) {
  const auto size = [](float x) { return x < 0 ? -x : x; };
  const bool flat = size(normal.y) >= size(normal.x) && size(normal.y) >= size(normal.z);
  const bool side = !flat && size(normal.x) >= size(normal.z);
  const float u = side ? place.z : place.x, v = flat ? place.z : -place.y;
  const float scale = static_cast<float>(all.levels[0].width) / material.scale;  // pixels per m
  const image::TextureLevel& shown = all.levels[level_for(all, footprint * scale)];
  const float height =
      material.scale * static_cast<float>(all.levels[0].height) / static_cast<float>(all.levels[0].width);
  return texel_mix(shown, repeated(u / material.scale, shown.width), repeated(v / height, shown.height), true);
}

}  // namespace motes::MOTES_ISA
