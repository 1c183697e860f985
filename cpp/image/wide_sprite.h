// What the kinds of sprites share where they are computed pixel by pixel: see docs/extending.md.
#pragma once

#include "image/layout.h"
#include "image/pixel_lanes.h"
#include "image/wide_lanes.h"

namespace motes::MOTES_ISA {

/// One wide record. Lengths are in pixels, y points down.
struct WideSprite {
  float x, y;          // middle of the streak, from the middle of the tile's first pixel
  float radius;        // half of the diameter
  float half;          // half of the streak's length; 0: none
  float along_x, along_y;  // direction of the streak, a unit vector
  float up_x, up_y;    // direction of the particle's `up`, a unit vector
  float light;         // part of its alpha that is shown
  std::uint32_t color, depth;
};

/// The light of a sprite at a vector of pixels, 0..1: what part of each pixel it covers, and that times the light of
/// its own red, green and blue. All three are equal but for kinds with kColored.
struct Glow {
  Floats cover, light[3];
};

/// An opaque sprite at a vector of pixels: where it is, its red, green and blue (in the lower 24 bits), the part of
/// that light it shows (0..1), and how much nearer than its centre it is, in pixels.
struct Front {
  Mask covered;
  Uints color;
  Floats shade, nearer;
};

MOTES_INLINE Floats clamp(Floats v, float low, float high) { return min(max(v, all(low)), all(high)); }

/// Where a pixel is beside a streak: along it and across, in radii.
struct Beside {
  Floats along, across;
};
MOTES_INLINE Beside beside(const WideSprite& s, Floats x, Floats y) {
  const float scale = 1 / s.radius;
  return {(x * s.along_x + y * s.along_y) * scale, (y * s.along_x - x * s.along_y) * scale};
}

/// The part of the streak's time in which a disc of one radius is over the pixel is that between `first` and `last`,
/// places in the disc, over its whole length.
struct Chord {
  Floats square;       // of half the disc's width across the streak; 0 where the disc passes by
  Floats first, last;  // first >= last where the disc is never over the pixel
};
MOTES_INLINE Chord chord(Beside p, float half) {
  Chord c;
  c.square = max(1.0f - p.across * p.across, Floats{});
  const Floats end = sqrt(c.square);
  c.first = max(p.along - half, -end);
  c.last = min(p.along + half, end);
  return c;
}

/// Shorter streaks, in radii, are drawn without one: the difference cannot be seen.
inline constexpr float kShortest = 1.0f / 64;

}  // namespace motes::MOTES_ISA
