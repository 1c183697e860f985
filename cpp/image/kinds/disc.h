// disc: flat in the middle, soft at the edge.
#pragma once

#include "image/wide_sprite.h"

namespace motes::image {

struct Disc {
  /// The part of its light at the square q of the distance from its middle, in radii; 0 <= q < 1.
  template <class Number>
  static MOTES_INLINE Number weight(Number q) {
    return (1 - q) * (1 - q);
  }
};

}  // namespace motes::image

namespace motes::MOTES_ISA {

struct Disc {
  static constexpr bool kColored = false;
  static constexpr float kNarrow = 2.25f;  // radius below which its light is normalised, px

  WideSprite s;
  float half;  // of the streak, in radii
  float gain;

  MOTES_INLINE Disc(const image::WideSplat& task, const WideSprite& sprite) : s(sprite) {
    half = s.half > kShortest * s.radius ? s.half / s.radius : 0;
    const float diameter = 2 * s.radius;
    const int below = diameter < image::kMaxFootprint ? static_cast<int>(diameter) : image::kMaxFootprint - 1;
    const float part = diameter < image::kMaxFootprint ? diameter - static_cast<float>(below) : 1;
    gain = s.light * (task.gain[below] + (task.gain[below + 1] - task.gain[below]) * part);
  }
  MOTES_INLINE float reach() const { return s.radius; }
  MOTES_INLINE Floats measured(const Glow& glow) const { return glow.cover; }
  /// Its light's mean is a third of that in its middle.
  MOTES_INLINE float total() const { return s.radius * s.radius * (3.14159265f / 3) * gain; }

  /// In motion, the mean of the disc's light over the streak: the integral of (k - t^2)^2, a polynomial.
  MOTES_INLINE Glow glow(Floats x, Floats y) const {
    const Beside p = beside(s, x, y);
    Floats weight;
    if (half > 0) {
      const Chord c = chord(p, half);
      const Floats k = c.square;
      const auto integral = [&](Floats t) {
        const Floats square = t * t;
        return t * (k * k + square * (square * 0.2f - k * (2.0f / 3)));
      };
      weight = max(integral(c.last) - integral(c.first), Floats{}) * (0.5f / half);
      weight = only(c.last > c.first, weight);
    } else {
      const Floats in = max(1.0f - (p.along * p.along + p.across * p.across), Floats{});
      weight = in * in;
    }
    weight = weight * gain;
    return {weight, {weight, weight, weight}};
  }

  MOTES_INLINE Front front(Floats x, Floats y) const {
    const Beside p = beside(s, x, y);
    const Floats along = p.along - clamp(p.along, -half, half);
    const Mask inside = along * along + p.across * p.across < 1.0f;
    return {inside, all_uints(s.color), all(1.0f), Floats{}};
  }
};

}  // namespace motes::MOTES_ISA
