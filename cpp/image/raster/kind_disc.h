// disc: flat in the middle, soft at the edge.
#pragma once

#include "image/disc_profile.h"
#include "image/raster/disc_lanes.h"

namespace motes::MOTES_ISA {

struct Disc : DiscShape {
  using Splat = image::DiscSplat;
  static constexpr int kPlanes = 1;
  static constexpr float kNarrow = 2.25f;  // radius below which its light is normalised, px

  WideSprite s;
  float half;  // half length of the streak, in radii
  float gain;

  MOTES_INLINE Disc(const image::WideSplat& task, const WideSprite& sprite) : s(sprite) {
    half = shown_half(s);
    const float diameter = 2 * s.radius;
    const int below = diameter < image::kMaxFootprint ? static_cast<int>(diameter) : image::kMaxFootprint - 1;
    const float part = diameter < image::kMaxFootprint ? diameter - static_cast<float>(below) : 1;
    const float (&gains)[image::kMaxFootprint + 1] = task.own<Splat>().gain;
    gain = s.light * (gains[below] + (gains[below + 1] - gains[below]) * part);
  }
  MOTES_INLINE float reach() const { return half > 0 ? s.radius * (1 / kSlim) : s.radius; }
  MOTES_INLINE float box_x() const { return s.radius; }
  MOTES_INLINE float box_y() const { return s.radius; }
  /// Returns the disc's total light, px^2. Its mean light is a third of that in the middle.
  MOTES_INLINE float total() const { return s.radius * s.radius * (3.14159265f / 3) * gain; }
  MOTES_INLINE float greatest() const { return half > 0 ? kStreakWeight : kStillWeight; }
  /// Returns the expected sum of the weights, exact for many pixels.
  MOTES_INLINE float usual_sum() const {
    const float square = s.radius * s.radius;
    if (!(half > 0)) return square * (3.14159265f / 3) * kStillWeight;
    return square * (16.0f / 15 / kSlim) * (2 * plateau() + ramp()) * kStreakWeight;
  }

  MOTES_INLINE void weigh(Patch<1>& p) const { half > 0 ? weigh_streak(p) : weigh_still(p); }
  static MOTES_INLINE const std::uint16_t* measured(const Patch<1>& p) { return p.cover; }

  MOTES_INLINE Front front(Floats x, Floats y) const {
    const Beside p = beside(s, x, y);
    const Floats along = p.along - clamp(p.along, -half, half);
    const Mask inside = along * along + p.across * p.across < 1.0f;
    return {inside, surface_of(all_uints(s.color), all(1.0f)), Floats{}};
  }

 private:
  /// Returns half the length of the plateau, in radii: there the light along the streak is constant; at both ends of it
  /// the light fades over ramp() radii.
  MOTES_INLINE float plateau() const { return half > 1 ? half - 1 : 0; }
  MOTES_INLINE float ramp() const { return half > 1 ? 2 : half + 1; }

  MOTES_OUTLINE void weigh_still(Patch<1>& p) const {
    const float scale = 1 / s.radius;
    std::int16_t rows[kPatchRows + kMoreRows], columns[kPatchStrips * kStrip + kWidth];
    for (int i = 0; i < p.stride; i += kWidth) {
      store_narrow(rows + i, fixed((numbers_from(p.first + i) - s.y) * scale));
    }
    for (int i = 0; i < p.strips * kStrip; i += kWidth) {
      store_narrow(columns + i, fixed((numbers_from(p.start[0] + i) - s.x) * scale));
    }
    for (int strip = 0; strip < p.strips; ++strip) {
      const Shorts across = square_of(eight_again(columns + strip * kStrip));
      std::uint16_t* to = p.cover + strip * p.stride * kStrip;
      for (int row = 0; row < p.stride; row += kRowsAtOnce, to += kShorts) {
        store_shorts(to, still(by_eights(rows + row), across));
      }
    }
  }

  MOTES_OUTLINE void weigh_streak(Patch<1>& p) const {
    const float scale = 1 / s.radius, narrow = scale * kSlim, end = scale / ramp(), level = plateau() * s.radius;
    std::int16_t across[kPatchRows + kMoreRows], after[kPatchRows + kMoreRows], before[kPatchRows + kMoreRows];
    for (int strip = 0; strip < p.strips; ++strip) {
      for (int i = 0; i < p.stride; i += kWidth) {
        const Floats y = numbers_from(p.first + i) - s.y;
        const Floats x = to_floats(load_mask(p.start + i) + strip * kStrip) - s.x;
        const Floats along = x * s.along_x + y * s.along_y;
        store_narrow(across + i, fixed((y * s.along_x - x * s.along_y) * narrow));
        store_narrow(after + i, fixed((along - level) * end));
        store_narrow(before + i, fixed((-along - level) * end));
      }
      std::int16_t step_across[kStrip + kWidth], step_along[kStrip + kWidth];
      for (int i = 0; i < kStrip; i += kWidth) {
        store_narrow(step_across + i, fixed(numbers_from(i) * (-s.along_y * narrow)));
        store_narrow(step_along + i, fixed(numbers_from(i) * (s.along_x * end)));
      }
      const Shorts to_side = eight_again(step_across), to_end = eight_again(step_along);
      std::uint16_t* to = p.cover + strip * p.stride * kStrip;
      for (int row = 0; row < p.stride; row += kRowsAtOnce, to += kShorts) {
        store_shorts(
            to, streak(add_saturating(by_eights(across + row), to_side), add_saturating(by_eights(after + row), to_end),
                       add_saturating(by_eights(before + row), Shorts{} - to_end)));
      }
    }
  }
};

/// The particles of a liquid are drawn together: see image/liquid.
struct Liquid : Disc {
  using Disc::Disc;
};

}  // namespace motes::MOTES_ISA
