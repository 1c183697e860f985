// sphere: shaded by the sun and the sky, round in depth.
#pragma once

#include "image/raster/wide_sprite.h"

namespace motes::MOTES_ISA {

struct Sphere {
  using Splat = image::SphereSplat;
  static constexpr int kPlanes = 2;
  static constexpr float kNarrow = 8;

  WideSprite s;
  const Splat& surface;
  float half;  // half length of the streak, in radii
  float mean_shade;  // over its disc
  float finer;  // scales weights up on long streaks, which would otherwise be rounded away

  MOTES_INLINE Sphere(const image::WideSplat& t, const WideSprite& sprite) : s(sprite), surface(t.own<Splat>()) {
    half = shown_half(s);
    finer = half > 1 ? half : 1;
    mean_shade = surface.mean_shade;
  }
  MOTES_INLINE float reach() const { return s.radius + 0.5f; }
  MOTES_INLINE float box_x() const { return reach(); }
  MOTES_INLINE float box_y() const { return reach(); }
  static MOTES_INLINE float greatest() { return kPixelWeight; }
  /// Returns the expected sum of the weights that weigh() computes.
  MOTES_INLINE float usual_sum() const { return total() * kPixelWeight * finer; }
  MOTES_OUTLINE void weigh(Patch<2>& p) const {
    const Sphere own = *this;  // no store to the patch can change it
    weigh_pixels(own, p);
  }
  static MOTES_INLINE const std::uint16_t* measured(const Patch<2>& p) { return p.light; }

  MOTES_INLINE float total() const { return s.radius * s.radius * 3.14159265f * mean_shade * s.light; }

  /// Returns the shade at a position on the sphere, along and across the streak, in radii; outside the sphere, that at
  /// the rim.
  MOTES_INLINE Floats shade(Floats along, Floats across) const {
    const Floats square = along * along + across * across;
    const Floats shrink = select(square > 1.0f, 1.0f / sqrt(square), all(1.0f));
    const Floats x = (along * s.along_x - across * s.along_y) * shrink;
    const Floats y = (along * s.along_y + across * s.along_x) * shrink;
    const Floats z = sqrt(max(1.0f - square, Floats{}));
    const Floats facing = x * surface.toward_sun[0] - y * surface.toward_sun[1] + z * surface.toward_sun[2];
    const Floats up = x * surface.upward[0] - y * surface.upward[1] + z * surface.upward[2];
    const Floats sky = surface.low + (surface.high - surface.low) * (0.5f + 0.5f * up);
    return min((sky + surface.sun * max(facing, Floats{})), all(1.0f));
  }

  MOTES_INLINE Glow glow(Floats x, Floats y) const {
    const Beside p = beside(s, x, y);
    if (!(half > 0)) {
      const Floats distance = sqrt(p.along * p.along + p.across * p.across);
      const Floats cover = clamp((1.0f - distance) * s.radius + 0.5f, 0, 1) * s.light;
      return {cover, cover * shade(p.along, p.across)};
    }
    // Mean shade while the sphere is over the pixel.
    const Chord c = chord(p, half);
    const Floats length = max(c.last - c.first, Floats{});
    const Floats cover = length * (0.5f / half * s.light * finer);
    Floats mean{};
    for (int i = 0; i < kSteps; ++i) {
      mean += shade(c.first + length * ((static_cast<float>(i) + 0.5f) / kSteps), p.across);
    }
    return {cover, cover * mean * (1.0f / kSteps)};
  }

  MOTES_INLINE Front front(Floats x, Floats y) const {
    const Beside p = beside(s, x, y);
    const Floats along = p.along - clamp(p.along, -half, half);
    const Floats under = 1.0f - (along * along + p.across * p.across);
    return {under > 0.0f, surface_of(all_uints(s.color), shade(along, p.across)),
            sqrt(max(under, Floats{})) * s.radius};
  }

 private:
  static constexpr int kSteps = 6;
};

}  // namespace motes::MOTES_ISA
