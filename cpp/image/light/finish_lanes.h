// Surfaces that reflect: what sun, lamps and sky add to the light that a surface scatters evenly. Compiled once for
// each instruction set.
//
// The model is that of most renderers, a GGX distribution of facets (Walter et al. 2007) with Schlick's Fresnel term,
// without powers and logarithms. A metal reflects in its colour, everything else in white; at a roughness of 1 only
// metals reflect, so that the defaults are exactly the even surface.
#pragma once

#include "image/light/sky_lanes.h"

namespace motes::MOTES_ISA {

/// The finish of surfaces, see image::Finish.
struct FinishLanes {
  Floats roughness, metal;
};
MOTES_INLINE FinishLanes finish_lanes(const image::Finish& finish) {
  return {all(finish.roughness), all(finish.metal)};
}

/// Light that a surface sends to the eye: `on_color` times its colour, plus `clear`.
struct Sent {
  Floats3 on_color, clear;
};
MOTES_INLINE Floats3 of_color(const Sent& sent, Floats3 color) {
  return {color.x * sent.on_color.x + sent.clear.x, color.y * sent.on_color.y + sent.clear.y,
          color.z * sent.on_color.z + sent.clear.z};
}

/// The reflections of one point, while they are added up.
class Gleam {
 public:
  /// `normal`, `to_eye`: unit vectors.
  MOTES_INLINE Gleam(const FinishLanes& finish, Floats3 normal, Floats3 to_eye)
      : normal_(normal), to_eye_(to_eye), metal_(finish.metal), roughness_(finish.roughness),
        smooth_(1.0f - finish.roughness * finish.roughness), facing_(max(dot(normal, to_eye), all(kGrazing))) {
    width_ = max(finish.roughness * finish.roughness, all(kNarrowest));
  }

  /// Adds light of the sun or a lamp. `arriving`: on the surface; `toward`: the way to its source, of any length.
  MOTES_INLINE void add(Floats3 arriving, Floats3 toward) {
    const Floats3 way = toward * (1.0f / sqrt(max(dot(toward, toward), all(1e-30f))));
    const Floats3 sum = way + to_eye_;
    const Floats3 half = sum * (1.0f / sqrt(max(dot(sum, sum), all(1e-30f))));
    const Floats3 aside = cross(normal_, half);  // precise where the highlight is brightest
    const Floats cosine = dot(normal_, half), square = width_ * width_;
    const Floats spread = dot(aside, aside) + square * cosine * cosine;
    const Floats lit = max(dot(normal_, way), Floats{});
    const Floats hides = (2.0f * lit * facing_) * (1.0f - width_) + (lit + facing_) * width_;
    const Floats bright = square / max(spread * spread, all(1e-12f)) * 0.5f / max(hides, all(1e-6f));
    add_reflected(arriving * bright, max(dot(half, to_eye_), Floats{}));
  }

  /// Adds the sky. Between a mirror and an even surface, its light is the mean over a growing part of the sky.
  MOTES_OUTLINE void add_sky(const image::SkyLanes& sky, const image::Ambient& ambient, Mask seen) {
    const Floats3 mirrored = normal_ * (2.0f * dot(normal_, to_eye_)) - to_eye_;
    const Floats3 even = ambient_at(ambient, mirrored);
    Floats3 light = even;
    if (sky.kind != image::Sky::Kind::none) {
      const Floats part = min(max(2.0f - 2.0f * roughness_, Floats{}), all(1.0f));
      light = sky_around(sky, mirrored, seen) * part + even * (1.0f - part);
    }
    add_reflected(light, facing_);
  }

  /// Returns all that a white mirror would reflect.
  MOTES_INLINE Floats3 reflected() const { return reflected_; }

  /// Returns what the surface sends if `scattered` is the light that falls on it.
  MOTES_INLINE Sent sent(Floats3 scattered) const {
    constexpr float kPlain = 0.04f;  // what most materials reflect of light that meets them at a right angle
    const Floats rim = rim_at(facing_), dull = 1.0f - metal_;
    const Floats kept = dull * (1.0f - (rim + kPlain * (smooth_ - rim)));
    return {scattered * kept + (reflected_ - rims_) * metal_, rims_ + (reflected_ * smooth_ - rims_) * (dull * kPlain)};
  }

 private:
  static constexpr float kGrazing = 1e-3f;    // least cosine between normal and eye
  static constexpr float kNarrowest = 5e-3f;  // about the radius of the sun
  static constexpr int kRays = 9;

  /// Returns how much more than a metal's own colour is reflected at a cosine.
  MOTES_INLINE Floats rim_at(Floats cosine) const {
    const Floats rest = 1.0f - min(cosine, all(1.0f)), square = rest * rest;
    return square * square * rest * smooth_;
  }
  MOTES_INLINE void add_reflected(Floats3 light, Floats cosine) {
    reflected_ = reflected_ + light;
    rims_ = rims_ + light * rim_at(cosine);
  }

  /// Returns the mean light of the sky around a direction, by kRays rays in a spiral.
  Floats3 sky_around(const image::SkyLanes& sky, Floats3 along, Mask seen) const {
    const Floats wide = max(width_ * 1.5f, all(0.006f));
    const Mask upright = along.y * along.y > 0.8f;
    const Floats3 axis{only(upright, all(1.0f)), only(~upright, all(1.0f)), Floats{}};
    const Floats3 aside = cross(along, axis);
    const Floats3 right = aside * (1.0f / sqrt(max(dot(aside, aside), all(1e-30f)))), up = cross(right, along);
    Floats3 sum{};
    float x = 1, y = 0;
    for (int i = 0; i < kRays; ++i) {
      const float out = __builtin_sqrtf((static_cast<float>(i) + 0.5f) / kRays);
      const Floats3 way = along + right * (wide * (x * out)) + up * (wide * (y * out));
      sum = sum + sky_blurred(sky, way, wide, seen);
      const float turned = x * kCosine - y * kSine;
      y = x * kSine + y * kCosine;
      x = turned;
    }
    return sum * (1.0f / kRays);
  }

  /// Returns the sky's light with details of about `wide` radians.
  static Floats3 sky_blurred(const image::SkyLanes& sky, Floats3 along, Floats wide, Mask seen) {
    if (sky.kind != image::Sky::Kind::picture) return sky_light(sky, along, seen);
    constexpr float kTexels = 0.0796f;  // of a ray, in turns per radian: half its share of the spiral
    const Floats flat = sqrt(max(along.x * along.x + along.z * along.z, all(1e-30f)));
    Floats texels = wide * (kTexels * static_cast<float>(sky.picture.levels[0].width));
    Floats3 light{};
    for (int level = 0; level < sky.picture.count && any(seen); ++level) {
      const Mask here = level + 1 < sky.picture.count ? seen & (texels <= 1.0f) : seen;
      if (any(here)) light = select(here, picture_light(sky.picture.levels[level], along, flat, here), light);
      seen &= ~here;
      texels *= 0.5f;
    }
    return light;
  }

  static constexpr float kCosine = -0.73736888f, kSine = 0.67549029f;  // of the golden angle

  Floats3 normal_, to_eye_;
  Floats metal_, roughness_, smooth_, facing_, width_;
  Floats3 reflected_{}, rims_{};
};

}  // namespace motes::MOTES_ISA
