// What the kinds of sprites share where they are computed pixel by pixel: see docs/extending.md.
#pragma once

#include "image/layout.h"
#include "image/raster/patch_lanes.h"
#include "image/raster/wide_lanes.h"

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

/// A sprite at a vector of pixels, 0..1: what part of each pixel it covers, and that times its light.
struct Glow {
  Floats cover, light;
};

/// An opaque sprite at a vector of pixels: where it is, its red, green and blue (in the lower 24 bits), the part of
/// that light it shows (0..1), and how much nearer than its centre it is, in pixels, at most its radius.
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
/// Half of the streak that is drawn, in radii.
MOTES_INLINE float shown_half(WideSprite& s) {
  if (!(s.half > kShortest * s.radius)) s.half = 0;
  return s.half / s.radius;
}

/// A vector of pixels of a strip: one or two rows of eight, or half of one.
struct Place {
  Floats x, y;  // from the middle of the tile's first pixel
};
inline constexpr int kPixelRows = kWidth > kStrip ? kWidth / kStrip : 1;
MOTES_INLINE Place place_of(const PatchPart& p, int strip, int row, int first) {
  Floats column, down;
  for (int lane = 0; lane < kWidth; ++lane) {
    column[lane] = static_cast<float>(lane % kStrip);
    down[lane] = static_cast<float>(lane / kStrip);
  }
  Floats start = all(static_cast<float>(p.start[row]));
  if constexpr (kPixelRows == 2) start = select(down == 0.0f, start, all(static_cast<float>(p.start[row + 1])));
  return {column + start + static_cast<float>(strip * kStrip + first), down + static_cast<float>(p.first + row)};
}

/// Where a vector of pixels begins in a part: a strip, its row, and a column of the strip.
struct InPart {
  int strip, row, first;
  MOTES_INLINE int number(const PatchPart& p) const { return kStrip * (strip * p.stride + row) + first; }
};

/// Calls use(x, y, in_part) for all vectors of pixels of a part: where they are on the screen, and in the part.
template <class Use>
MOTES_INLINE void for_each_vector(const PatchPart& p, const Use& use) {
  for (int strip = 0; strip < p.strips; ++strip) {
    for (int row = 0; row < p.rows; row += kPixelRows) {
      for (int first = 0; first < kStrip; first += kWidth) {
        const Place at = place_of(p, strip, row, first);
        use(at.x, at.y, InPart{strip, row, first});
      }
    }
  }
}

/// The weight of what covers a pixel: see Patch.
inline constexpr float kPixelWeight = 16384;
MOTES_INLINE Ints weight_of(Floats part) { return to_ints(clamp(part, 0, 1) * kPixelWeight + 0.5f); }

template <class Kind>
MOTES_INLINE void weigh_pixels(const Kind& kind, Patch<2>& p) {
  for_each_vector(p, [&](Floats x, Floats y, const InPart& in_part) {
    const Glow glow = kind.glow(x - kind.s.x, y - kind.s.y);
    const int at = in_part.number(p);
    store_narrow(p.cover + at, weight_of(glow.cover));
    store_narrow(p.light + at, weight_of(glow.light));
  });
}

}  // namespace motes::MOTES_ISA
