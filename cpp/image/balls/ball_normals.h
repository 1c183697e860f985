// Where rays meet a sphere that is seen in any direction. Compiled once for each instruction set.
#pragma once

#include "simd/floats3.h"

namespace motes::MOTES_ISA {

/// Returns the normals of a sphere, in the camera's axes, where the rays through pixels meet it.
/// `middle`: direction to its centre, whose depth is 1; `wide`: its radius at that depth; (x, y): the pixels' places
/// relative to the centre's, to the right and up, in radii, at most 1 in length.
MOTES_INLINE Floats3 ball_normals(Float3 middle, float wide, Floats x, Floats y) {
  // The vector `out` of the normal is `aside`, from the centre to the ray and at right angles to it, minus a part of
  // the ray.
  const Floats ray_x = x * wide + middle.x, ray_y = y * wide + middle.y;
  const Floats inverse = 1.0f / (ray_x * ray_x + ray_y * ray_y + 1.0f);
  const Floats along = x * ray_x + y * ray_y, back = along * inverse;
  const Floats under = max(1.0f - (x * x + y * y) + along * back, Floats{});
  const Floats part = back + sqrt(under * inverse);
  return {x - ray_x * part, y - ray_y * part, part};
}

/// Places spread evenly over a disc, in radii, to measure the mean light on a sphere.
struct DiscPlaces {
  static constexpr int kCount = 32;
  float x[kCount], y[kCount];
};
inline constexpr DiscPlaces kDiscPlaces = [] {
  constexpr float kRing[4] = {0.35355339f, 0.61237244f, 0.79056942f, 0.93541435f};
  constexpr float kCosine[2][8] = {
      {1, 0.70710678f, 0, -0.70710678f, -1, -0.70710678f, 0, 0.70710678f},
      {0.92387953f, 0.38268343f, -0.38268343f, -0.92387953f, -0.92387953f, -0.38268343f, 0.38268343f, 0.92387953f}};
  constexpr float kSine[2][8] = {
      {0, 0.70710678f, 1, 0.70710678f, 0, -0.70710678f, -1, -0.70710678f},
      {0.38268343f, 0.92387953f, 0.92387953f, 0.38268343f, -0.38268343f, -0.92387953f, -0.92387953f, -0.38268343f}};
  DiscPlaces all{};
  for (int ring = 0; ring < 4; ++ring) {
    for (int i = 0; i < 8; ++i) {
      all.x[8 * ring + i] = kRing[ring] * kCosine[ring % 2][i];
      all.y[8 * ring + i] = kRing[ring] * kSine[ring % 2][i];
    }
  }
  return all;
}();

/// Returns the mean of light(x, y), a vector of numbers for places on a disc.
template <class Light>
MOTES_INLINE float mean_on_disc(const Light& light) {
  float all[DiscPlaces::kCount], sum = 0;
  for (std::size_t i = 0; i < DiscPlaces::kCount; i += kLanes) {
    store(all + i, light(load(kDiscPlaces.x + i), load(kDiscPlaces.y + i)));
  }
  for (const float number : all) sum += number;
  return sum * (1.0f / DiscPlaces::kCount);
}

}  // namespace motes::MOTES_ISA
