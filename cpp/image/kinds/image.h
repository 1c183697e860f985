// image: a picture, turned by the particle's `up`.
#pragma once

#include "image/wide_sprite.h"

namespace motes::MOTES_ISA {

struct Image {
  static constexpr bool kColored = true;
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

  MOTES_INLINE Floats measured(const Glow& glow) const { return glow.cover; }
  MOTES_INLINE float total() const { return 4 * s.radius * s.radius * cover * s.light; }

  struct Texels {
    Floats channel[4];  // light times alpha, alpha; 0..1
  };

  MOTES_INLINE Glow glow(Floats x, Floats y) const {
    Texels sum{};
    for (int i = 0; i < steps; ++i) {
      const float along = (static_cast<float>(i) + 0.5f) * step - s.half;
      const Texels here = texels(x - along * s.along_x, y - along * s.along_y);
      for (int c = 0; c < 4; ++c) sum.channel[c] += here.channel[c];
    }
    const float part = s.light / static_cast<float>(steps);
    return {sum.channel[3] * part, {sum.channel[0] * part, sum.channel[1] * part, sum.channel[2] * part}};
  }

  /// Where it is at least half opaque, in the middle of its streak.
  MOTES_INLINE Front front(Floats x, Floats y) const {
    const Texels t = texels(x, y);
    const Floats alpha = max(t.channel[3], all(0.5f));
    Uints color{};
    for (int c = 0; c < 3; ++c) {
      const Floats own = to_floats((Ints)all_uints(s.color >> (8 * c) & 0xffu));
      color |= (Uints)to_ints(min(own * t.channel[c] / alpha, all(255.0f)) + 0.5f) << (8 * c);
    }
    return {t.channel[3] >= 0.5f, color, all(1.0f), Floats{}};
  }

 private:
  static constexpr int kMostSteps = 64;

  using Channels4 = float __attribute__((vector_size(16)));
  static MOTES_INLINE Channels4 channels_at(const std::uint16_t* texel) {
    using Shorts = std::uint16_t __attribute__((vector_size(8)));
    using Numbers = std::int32_t __attribute__((vector_size(16)));
    Shorts four;
    __builtin_memcpy(&four, texel, sizeof four);
    return __builtin_convertvector(__builtin_convertvector(four, Numbers), Channels4);
  }

  /// Between the middles of four texels, by how near they are.
  MOTES_INLINE Texels texels(Floats x, Floats y) const {
    // The picture's x is a quarter turn to the right of `up`.
    const Floats across = (y * s.up_x - x * s.up_y) * scale, down = -(x * s.up_x + y * s.up_y) * scale;
    const float width = static_cast<float>(level.width), height = static_cast<float>(level.height);
    // From the middle of the frame's first texel; outside the frame everything is transparent.
    const Floats column = clamp(across + (0.5f * width + 0.5f), 0, width + 1);
    const Floats row = clamp(down + (0.5f * height + 0.5f), 0, height + 1);
    Texels t;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      int c = static_cast<int>(column[lane]), r = static_cast<int>(row[lane]);
      c = c < level.width ? c : level.width;
      r = r < level.height ? r : level.height;
      const float right = column[lane] - static_cast<float>(c), below = row[lane] - static_cast<float>(r);
      const std::uint16_t* upper = level.texels + 4 * (static_cast<std::ptrdiff_t>(r) * (level.width + 2) + c);
      const std::uint16_t* lower = upper + static_cast<std::ptrdiff_t>(4) * (level.width + 2);
      const Channels4 above = channels_at(upper) * (1 - right) + channels_at(upper + 4) * right;
      const Channels4 under = channels_at(lower) * (1 - right) + channels_at(lower + 4) * right;
      const Channels4 here = (above * (1 - below) + under * below) * (1 / 65535.0f);
      for (int i = 0; i < 4; ++i) t.channel[i][lane] = here[i];
    }
    return t;
  }
};

}  // namespace motes::MOTES_ISA
