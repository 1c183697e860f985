// sphere: shaded by the sun and the sky, round in depth.
#pragma once

#include "image/balls/ball_normals.h"
#include "image/light/surface_lanes.h"
#include "image/raster/wide_sprite.h"

namespace motes::MOTES_ISA {

struct Sphere {
  using Splat = image::SphereSplat;
  static constexpr int kPlanes = 2;
  static constexpr float kNarrow = 8;

  WideSprite s;
  const image::SurfaceSplat& surface;
  float blur;  // radius of the lens blur, px
  float half;  // half length of the streak, in radii
  Float3 middle;  // direction to its centre, whose depth is 1 m
  float wide;  // its radius at that depth, m
  float mean_shade = 1;  // over its disc, where the sum of weights does not cancel it
  float finer;  // scales weights up on long streaks, which would otherwise be rounded away

  MOTES_INLINE Sphere(const image::WideSplat& t, const WideSprite& sprite)
      : s(sprite), surface(t.own<Splat>().surface), blur(blur_of(t.own<Splat>(), sprite)) {
    half = shown_half(s);
    finer = half > 1 && !(blur > 0) ? half : 1;
    middle = middle_of(t, s);
    wide = s.radius * t.radius;
    if (t.light == nullptr && (is_narrow() || blur > 0)) {
      mean_shade = mean_on_disc([&](Floats x, Floats y) { return shade_at(x, y); });
    }
  }
  MOTES_INLINE float reach() const { return s.radius + blur + 0.5f; }
  /// Returns whether its weights must be added up, because their expected sum is not exact.
  MOTES_INLINE bool is_narrow() const { return s.radius < kNarrow || (blur > 0 && s.radius < kMeasured); }
  MOTES_INLINE float box_x() const { return reach(); }
  MOTES_INLINE float box_y() const { return reach(); }
  static MOTES_INLINE float greatest() { return kPixelWeight; }
  /// Returns the expected sum of the weights that weigh() computes.
  MOTES_INLINE float usual_sum() const {
    if (!(blur > 0)) return total() * kPixelWeight * finer;
    return blurred_area() * mean_shade * s.light * kPixelWeight;
  }
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
    return shade_at((along * s.along_x - across * s.along_y) * shrink,
                    (along * s.along_y + across * s.along_x) * -shrink);
  }

  MOTES_INLINE Glow glow(Floats x, Floats y) const {
    const Beside p = beside(s, x, y);
    if (blur > 0) return blurred(p);
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

 protected:
  /// Returns the shade at a position on the sphere, to the right and up, in radii.
  MOTES_INLINE Floats shade_at(Floats x, Floats y) const {
    const Floats3 normal = ball_normals(middle, wide, x, y);
    const Floats facing = dot(normal, all3(surface.toward_sun)), up = dot(normal, all3(surface.upward));
    const Floats sky = surface.low + (surface.high - surface.low) * (0.5f + 0.5f * up);
    return min((sky + surface.sun * max(facing, Floats{})), all(1.0f));
  }

  /// Returns the integral of what cover_blurred() returns without a streak, per light, px2.
  MOTES_INLINE float blurred_area() const {
    const float inner = size_of(s.radius - blur), ramp = s.radius + blur - inner;
    return (inner * inner + inner * ramp + 0.3f * ramp * ramp) * 3.14159265f;
  }

  /// Returns the mean cover over the lens, and over the streak: a disc over a disc, whose overlap falls smoothly from
  /// where one contains the other to where they touch. Calls add(part, own, along, across) for parts of the streak:
  /// how much of the cover it is, and the light there, that at a place on the sphere by `own` and its mean otherwise.
  template <class Add>
  MOTES_INLINE Floats cover_blurred(Beside p, const Add& add) const {
    const float end = 1 + blur / s.radius, inner = size_of(1 - blur / s.radius), per_ramp = 1 / (end - inner);
    const float own = 1 / end;  // of the light's contrast
    const float most = 2 * half / end < 15 ? 2 * half / end : 15;
    const int steps = half > 0 ? 2 + static_cast<int>(most) : 1;
    const float per = s.light / static_cast<float>(steps);
    Floats cover{};
    for (int i = 0; i < steps; ++i) {
      const Floats along = p.along - half * ((2 * static_cast<float>(i) + 1) / static_cast<float>(steps) - 1);
      const Floats distance = sqrt(along * along + p.across * p.across);
      const Floats fall = clamp((distance - inner) * per_ramp, 0, 1);
      const Floats part = (1.0f - fall * fall * (3.0f - 2.0f * fall)) * per;
      cover += part;
      add(part, own, along * (1 / end), p.across * (1 / end));
    }
    return cover;
  }

 private:
  static constexpr int kSteps = 6;
  static constexpr float kMeasured = 64;

  static MOTES_INLINE float blur_of(const Splat& camera, const WideSprite& sprite) {
    if (!(camera.blur > 0)) return 0;
    float depth;
    __builtin_memcpy(&depth, &sprite.depth, sizeof depth);
    const float spread = size_of(image::spread_at(camera.blur, camera.focus, 1 / depth));
    return spread < 0.25f ? 0 : spread < image::kMostPosedReach ? spread : image::kMostPosedReach;
  }

  MOTES_INLINE Glow blurred(Beside p) const {
    Floats light{};
    const auto add = [&](Floats part, float own, Floats along, Floats across) __attribute__((always_inline)) {
      light += part * (mean_shade + (shade(along, across) - mean_shade) * own);
    };
    return {cover_blurred(p, add), light};
  }
};

/// A sphere whose light has a colour: a lit one, or one that is seen through fog.
struct LitSphere : Sphere {
  static constexpr int kPlanes = 4;

  const image::SurfaceLight& light;
  Floats3 own;  // its colour
  float depth;  // of its centre, m

  MOTES_INLINE LitSphere(const image::WideSplat& t, const WideSprite& sprite)
      : Sphere(t, sprite), light(*t.light), own(color_times(s.color, s.gain)) {
    s.color |= 0xffffffu;
    __builtin_memcpy(&depth, &s.depth, sizeof depth);
  }
  // NOLINTBEGIN(bugprone-derived-method-shadowing-base-method): kernels know the kind when they are compiled
  MOTES_INLINE float total() const { return s.radius * s.radius * 3.14159265f * s.light; }
  MOTES_INLINE float usual_sum() const {
    return (blur > 0 ? blurred_area() * s.light : total() * finer) * kPixelWeight;
  }
  // NOLINTEND(bugprone-derived-method-shadowing-base-method)
  static MOTES_INLINE const std::uint16_t* measured(const Patch<4>& p) { return p.cover; }

  MOTES_OUTLINE void weigh(Patch<4>& p) const {
    const LitSphere kind = *this;  // no store to the patch can change it
    for_each_vector(p, [&](Floats x, Floats y, const InPart& in_part) {
      Floats3 shown;
      const Floats cover = kind.glow(x - kind.s.x, y - kind.s.y, shown);
      const int at = in_part.number(p);
      store_narrow(p.cover + at, weight_of(cover));
      store_thirds(p.light + 3 * at, weight_of(cover * shown.x), weight_of(cover * shown.y),
                   weight_of(cover * shown.z));
    });
  }

  /// `shows`: tells which pixels to shade, of those that it covers, given how much nearer than its centre they are.
  template <class Shows>
  MOTES_INLINE Front front(Floats x, Floats y, const Shows& shows) const {
    const Beside p = beside(s, x, y);
    const Floats along = p.along - clamp(p.along, -half, half);
    const Floats under = 1.0f - (along * along + p.across * p.across);
    const Floats nearer = sqrt(max(under, Floats{})) * s.radius;
    const Mask covered = (under > 0.0f) & shows(under > 0.0f, nearer);
    if (!any(covered)) return {covered, Uints{}, Floats{}};
    return {covered, surface_of(shown(along, p.across)), nearer};
  }
  // NOLINTNEXTLINE(bugprone-derived-method-shadowing-base-method): kernels know the kind when they are compiled
  MOTES_INLINE Front front(Floats x, Floats y) const {
    return front(x, y, [](Mask there, Floats) { return there; });
  }

 private:
  static constexpr int kSteps = 6;

  /// Returns the light at a position on the sphere, along and across the streak, in radii.
  MOTES_INLINE Floats3 shown(Floats along, Floats across) const {
    const Floats3 normal =
        ball_normals(middle, wide, along * s.along_x - across * s.along_y, -(along * s.along_y + across * s.along_x));
    const Floats3 place = all3(middle) * depth + normal * (wide * depth);
    if (light.lit) return through_fog(light, light_of_surface(light, {place, normal}, own), place);
    return through_fog(light, own * shade(along, across), place);
  }

  /// Returns the covered part of pixels, and in `light` that of the sphere there, at most white.
  MOTES_INLINE Floats glow(Floats x, Floats y, Floats3& mean) const {
    const Beside p = beside(s, x, y);
    if (blur > 0) return blurred(p, mean);
    if (!(half > 0)) {
      const Floats distance = sqrt(p.along * p.along + p.across * p.across);
      const Floats cover = clamp((1.0f - distance) * s.radius + 0.5f, 0, 1) * s.light;
      // At the rim, show the middle of the covered part of the pixel.
      const float edge = 0.5f / s.radius;
      const Floats to = select(distance > 1.0f - edge, (distance + (1.0f - edge)) * 0.5f, distance);
      const Floats part = to / max(distance, all(1e-12f));
      mean = any(cover > 0.0f) ? at_most_white(shown(p.along * part, p.across * part)) : Floats3{};
      return cover;
    }
    const Chord c = chord(p, half);
    const Floats length = max(c.last - c.first, Floats{});
    mean = Floats3{};
    for (int i = 0; i < kSteps && any(length > 0.0f); ++i) {
      const Floats along = c.first + length * ((static_cast<float>(i) + 0.5f) / kSteps);
      mean = mean + at_most_white(shown(along, p.across)) * (1.0f / kSteps);
    }
    return length * (0.5f / half * s.light * finer);
  }

  MOTES_INLINE Floats blurred(Beside p, Floats3& mean) const {
    constexpr float kAside = 0.6f;  // from the middle, radii
    const Floats3 all_around = at_most_white(shown(Floats{}, Floats{})) + at_most_white(shown(all(kAside), Floats{})) +
                               at_most_white(shown(all(-kAside), Floats{})) +
                               at_most_white(shown(Floats{}, all(kAside))) +
                               at_most_white(shown(Floats{}, all(-kAside)));
    const Floats3 usual = all_around * 0.2f;
    Floats3 sum{};
    const auto add = [&](Floats part, float own, Floats along, Floats across) __attribute__((always_inline)) {
      sum = sum + (usual + (at_most_white(shown(along, across)) - usual) * own) * part;
    };
    const Floats cover = cover_blurred(p, add);
    mean = sum * (1.0f / max(cover, all(1e-12f)));
    return cover;
  }
};

}  // namespace motes::MOTES_ISA
