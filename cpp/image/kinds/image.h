// image: a picture, turned by the particle's `up`.
#pragma once

#include "image/wide_sprite.h"

namespace motes::MOTES_ISA {

/// Four numbers, of red, green, blue and alpha.
using Texel = std::int32_t __attribute__((vector_size(16)));

struct Image {
  static constexpr int kPlanes = 4;
  static constexpr float kNarrow = 8;

  WideSprite s;
  image::ImageLevel level;
  float scale;    // texels per pixel
  float cover;
  int steps = 1;  // places along the streak
  float step = 0;

  MOTES_INLINE Image(const image::WideSplat& task, const WideSprite& sprite) : s(sprite) {
    const image::ImageLevel& first = task.levels[0];
    const int longer = first.width > first.height ? first.width : first.height;
    scale = static_cast<float>(longer) / (2 * s.radius);
    cover = task.image_cover;
    int number = 0;  // the largest level with at most about one texel per pixel
    for (; scale > 1.5f && number + 1 < task.level_count; ++number) scale *= 0.5f;
    level = task.levels[number];
    if (s.half > 0) {
      const float length = 2 * s.half;
      steps = length < kMostSteps ? 1 + static_cast<int>(length) : kMostSteps;
      step = length / static_cast<float>(steps);
    }
  }
  /// Half of the diagonal of a square, and half a pixel for what is between texels.
  MOTES_INLINE float reach() const { return s.radius * 1.4143f + 1 / scale; }
  MOTES_INLINE float box_x() const { return box(size_of(s.up_y), size_of(s.up_x)); }
  MOTES_INLINE float box_y() const { return box(size_of(s.up_x), size_of(s.up_y)); }

  MOTES_INLINE float total() const { return 4 * s.radius * s.radius * cover * s.light; }
  static MOTES_INLINE float greatest() { return kPixelWeight; }
  /// Unscaled: as large as the picture.
  MOTES_INLINE float usual_sum() const { return 4 * s.radius * s.radius * cover * kPixelWeight; }
  static MOTES_INLINE const std::uint16_t* measured(const Patch<4>& p) { return p.cover; }

  MOTES_INLINE void weigh(Patch<4>& p) const {
    for_each_vector(p, [&](Floats x, Floats y, int at) {
      Texel texel[kLanes];
      texels(x - s.x, y - s.y, texel);
      for (int lane = 0; lane < kWidth; ++lane) {
        p.cover[at + lane] = static_cast<std::uint16_t>(texel[lane][3]);
        store_color(p.light + 3 * (at + lane), texel[lane]);
      }
    });
  }

  /// Where it is at least half opaque, in the middle of its streak.
  MOTES_INLINE Front front(Floats x, Floats y) const {
    Texel texel[kLanes];
    place(x, y, texel);
    Front front;
    Floats channel[4];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      for (int c = 0; c < 4; ++c) channel[c][lane] = static_cast<float>(texel[lane][c]);
    }
    const Floats alpha = max(channel[3], all(0.5f * kPixelWeight));
    front.color = Uints{};
    for (int c = 0; c < 3; ++c) {
      const Floats own = all(static_cast<float>(s.color >> (8 * c) & 0xffu));
      front.color |= (Uints)to_ints(min(own * channel[c] / alpha, all(255.0f)) + 0.5f) << (8 * c);
    }
    front.covered = channel[3] >= 0.5f * kPixelWeight;
    front.shade = all(1.0f);
    front.nearer = Floats{};
    return front;
  }

 private:
  static constexpr int kMostSteps = 64;
  static constexpr int kPartBits = 7;  // of a texel, in places between texels

  /// How far the turned picture and its frame reach along one axis, where its sides are that much along it.
  MOTES_INLINE float box(float of_width, float of_height) const {
    return (of_width * static_cast<float>(level.width + 1) + of_height * static_cast<float>(level.height + 1)) * 0.5f /
           scale;
  }

  static MOTES_INLINE void store_color(std::uint16_t* to, Texel t) {
    for (int c = 0; c < 3; ++c) to[c] = static_cast<std::uint16_t>(t[c]);
  }

  /// The mean over the streak.
  MOTES_INLINE void texels(Floats x, Floats y, Texel (&to)[kLanes]) const {
    if (steps == 1) return place(x, y, to);
    Texel sum[kLanes] = {};
    for (int i = 0; i < steps; ++i) {
      const float along = (static_cast<float>(i) + 0.5f) * step - s.half;
      place(x - along * s.along_x, y - along * s.along_y, to);
      for (std::size_t lane = 0; lane < kLanes; ++lane) sum[lane] += to[lane];
    }
    const int part = 65536 / steps;
    for (std::size_t lane = 0; lane < kLanes; ++lane) to[lane] = sum[lane] * part >> 16;
  }

  /// Between the middles of four texels, by how near they are: weights like those of Patch.
  MOTES_INLINE void place(Floats x, Floats y, Texel (&to)[kLanes]) const {
    // The picture's x is a quarter turn to the right of `up`.
    const Floats across = (y * s.up_x - x * s.up_y) * scale, down = -(x * s.up_x + y * s.up_y) * scale;
    const float width = static_cast<float>(level.width), height = static_cast<float>(level.height);
    // From the middle of the frame's first texel; outside the frame everything is transparent.
    constexpr int kOne = 1 << kPartBits;
    const Ints column = to_ints(clamp(across + (0.5f * width + 0.5f), 0, width + 1) * float{kOne});
    const Ints row = to_ints(clamp(down + (0.5f * height + 0.5f), 0, height + 1) * float{kOne});
    const Ints first_column = min_ints(column >> kPartBits, all_ints(level.width));
    const Ints first_row = min_ints(row >> kPartBits, all_ints(level.height));
    const Ints right = column - (first_column << kPartBits), below = row - (first_row << kPartBits);
    // Weights of the left and right texel: the lower and upper half of each lane.
    const Ints pair = (kOne - right) | right << 16;
    const int stride = 4 * (level.width + 2);
    std::int32_t index[kLanes], upper[kLanes], lower[kLanes];
    store_mask(index, first_row * stride + first_column * 4);
    store_mask(upper, pair * (kOne - below));
    store_mask(lower, pair * below);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      to[lane] = between(level.texels + index[lane], stride, upper[lane], lower[lane]);
    }
  }

  static MOTES_INLINE Texel between(const std::uint16_t* texels, int stride, std::int32_t upper, std::int32_t lower) {
#if MOTES_WIDTH != 0
    const auto row = [](const std::uint16_t* from, std::int32_t weights) {
      const __m128i two = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
      return _mm_madd_epi16(_mm_unpacklo_epi16(two, _mm_srli_si128(two, 8)), _mm_set1_epi32(weights));
    };
    return (Texel)_mm_add_epi32(row(texels, upper), row(texels + stride, lower)) >> 15;
#else
    Texel sum;
    for (int c = 0; c < 4; ++c) {
      const auto row = [&](const std::uint16_t* from, std::int32_t weights) {
        return from[c] * (weights & 0xffff) + from[c + 4] * (weights >> 16);
      };
      sum[c] = (row(texels, upper) + row(texels + stride, lower)) >> 15;
    }
    return sum;
#endif
  }
};

}  // namespace motes::MOTES_ISA
