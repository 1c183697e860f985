// The light of the sky in given directions, and of pictures on surfaces. Compiled once for each instruction set.
#pragma once

#include "image/light/sky.h"
#include "simd/elementary.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Floats3 mix3(const float* from, const float* to, Floats part) {
  return all3(from) * (1.0f - part) + all3(to) * part;
}

/// Returns the ambient light on surfaces with these unit normals. For the mean over the visible side of a ball, whose
/// normals are those of a surface that faces the eye only on average, `normal` is the direction to the eye, `linear`
/// 2/3 and `square` 1/4.
MOTES_INLINE Floats3 ambient_at(const image::Ambient& a, Floats3 normal, float linear = 1, float square = 1) {
  if (!a.of_sky) {
    const Floats up = 0.5f + normal.y * (0.5f * linear);
    return all3(a.low) * (1.0f - up) + all3(a.high) * up;
  }
  const Floats terms[6] = {normal.x * normal.x,        normal.y * normal.y,        normal.z * normal.z,
                           2.0f * normal.x * normal.y, 2.0f * normal.y * normal.z, 2.0f * normal.z * normal.x};
  Floats3 light = all3(a.mean) * (1.0f - 0.625f * square) + all3(a.slope[0]) * (normal.x * linear) +
                  all3(a.slope[1]) * (normal.y * linear) + all3(a.slope[2]) * (normal.z * linear);
  for (int i = 0; i < 6; ++i) light = light + all3(a.curve[i]) * (terms[i] * square);
  return {max(light.x, Floats{}), max(light.y, Floats{}), max(light.z, Floats{})};
}

/// Returns a pixel's index, wrapped into 0..pixels - 1.
MOTES_INLINE int repeated(int at, int pixels) {
  const int rest = at % pixels;
  return rest < 0 ? rest + pixels : rest;
}

/// Returns the light of a level at (u, v), px from its top left corner, interpolated bilinearly. The picture repeats
/// horizontally, and vertically only if `wraps`.
inline Float3 texel_mix(const image::TextureLevel& level, float u, float v, bool wraps) {
  const float x = u - 0.5f, y = v - 0.5f;
  const auto floor_of = [](float value) {
    const int whole = static_cast<int>(value);
    return static_cast<float>(whole) > value ? whole - 1 : whole;
  };
  const int column = floor_of(x), row = floor_of(y);
  const float right = x - static_cast<float>(column), below = y - static_cast<float>(row);
  const auto row_at = [&](int at) {
    if (wraps) return repeated(at, level.height);
    return at < 0 ? 0 : at < level.height ? at : level.height - 1;
  };
  const auto pixel = [&](int i, int j) {
    return of(level.light + 3 * (static_cast<std::ptrdiff_t>(row_at(j)) * level.width + repeated(i, level.width)));
  };
  const auto between = [](Float3 a, Float3 b, float part) {
    return Float3{a.x + (b.x - a.x) * part, a.y + (b.y - a.y) * part, a.z + (b.z - a.z) * part};
  };
  return between(between(pixel(column, row), pixel(column + 1, row), right),
                 between(pixel(column, row + 1), pixel(column + 1, row + 1), right), below);
}

/// Returns the light of a level of an equirectangular picture. `flat`: length of the horizontal part of `along`.
inline Floats3 picture_light(const image::TextureLevel& level, Floats3 along, Floats flat, Mask seen) {
  constexpr float kTurn = 0.15915494309f, kHalfTurn = 0.31830988618f;
  const Floats u = 0.5f + atan2(along.x, -along.z) * kTurn, v = 0.5f - atan2(along.y, flat) * kHalfTurn;
  Floats3 light{};
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (seen[lane] == 0) continue;
    const float width = static_cast<float>(level.width), height = static_cast<float>(level.height);
    set_lane(light, lane, texel_mix(level, u[lane] * width, v[lane] * height, false));
  }
  return light;
}

/// Returns the sky's light from directions of any length; only the lanes of `seen` are valid.
inline Floats3 sky_light(const image::SkyLanes& sky, Floats3 along, Mask seen) {
  if (sky.kind == image::Sky::Kind::none) return all3(sky.color);
  const Floats flat = sqrt(max(along.x * along.x + along.z * along.z, all(1e-30f)));
  if (sky.kind == image::Sky::Kind::gradient) {
    const Floats height = along.y / sqrt(max(flat * flat + along.y * along.y, all(1e-30f)));
    return select(height > 0.0f, mix3(sky.horizon, sky.zenith, max(height, Floats{})),
                  mix3(sky.horizon, sky.ground, max(-height, Floats{})));
  }
  return picture_light(sky.picture.levels[0], along, flat, seen);
}

}  // namespace motes::MOTES_ISA
