// image: a picture, turned by the particle's `up`.
#pragma once

#include "image/light/surface_lanes.h"
#include "image/raster/wide_sprite.h"
#include "simd/quads.h"

namespace motes::MOTES_ISA {

/// Red, green, blue and alpha at a vector of pixels, as in an ImageLevel.
struct Texels {
  Ints channel[4];
};

/// A picture on a wide sprite, and the streak along which it moves. `Kind` provides its geometry: reach(), texels() and
/// point(), to which it gives this class access.
template <class Kind>
struct Picture {
  static constexpr int kPlanes = 4;

  WideSprite s;
  image::ImageLevel level;
  const std::uint16_t* next = nullptr;  // the same level of the next tile, which is blended in
  int part = 0;                         // weight of the next tile, 1/256
  float across, down;   // texels per pixel along width and height
  float width, height;  // px
  float cover;
  float least;      // least alpha that counts as covered by an opaque particle
  bool moves;
  int steps = 1;    // samples along the streak per pixel
  float finer = 1;  // scales weights up on long streaks, which would otherwise be rounded away
  const image::SurfaceLight* light;  // null: none
  Floats3 own;  // colour, if there is light

  static MOTES_INLINE float greatest() { return kPixelWeight; }
  static MOTES_INLINE const std::uint16_t* measured(const Patch<4>& p) { return p.cover; }

  MOTES_OUTLINE void weigh_still(Patch<4>& p) const {
    const Kind own = self();  // no store to the patch can change it
    for_each_vector(p, [&](Floats x, Floats y, const InPart& in_part) {
      Texels t = own.mean(x - own.s.x, y - own.s.y);
      own.dress(t, x - own.s.x, y - own.s.y);
      const int at = in_part.number(p);
      store_narrow(p.cover + at, t.channel[3]);
      store_thirds(p.light + 3 * at, t.channel[0], t.channel[1], t.channel[2]);
    });
  }

 protected:
  static constexpr int kMostSteps = 64;
  static constexpr int kPartBits = 7;  // fractional bits of positions between texels

  MOTES_INLINE const Kind& self() const { return static_cast<const Kind&>(*this); }

  /// Chooses the largest level with at most about one texel per pixel and returns its greatest alpha relative to the
  /// picture's. `half`: of the longer side, px; `squeezed`: px on the sprite per px on the screen.
  MOTES_INLINE float choose_level(const image::PictureSplat& task, float half, float squeezed) {
    const image::ImageLevel& first = tile_levels[0];
    const int longer = first.width > first.height ? first.width : first.height;
    float scale = static_cast<float>(longer) / (2 * half);
    int number = 0;
    for (; scale * squeezed > 1.5f && number + 1 < task.level_count; ++number) scale *= 0.5f;
    level = tile_levels[number];
    across = scale * level.across;
    down = scale * level.down;
    width = static_cast<float>(level.width) / across;
    height = static_cast<float>(level.height) / down;
    const float opaque = static_cast<float>(level.most_alpha) / static_cast<float>(first.most_alpha);
    if (part == 0) return opaque;
    next = next_levels[number].texels;
    const float other =
        static_cast<float>(next_levels[number].most_alpha) / static_cast<float>(next_levels->most_alpha);
    return opaque + (other - opaque) * (static_cast<float>(part) * kPart);
  }

  MOTES_INLINE void choose_steps() {
    if (!moves) return;
    const float longest = s.half < self().reach() ? s.half : self().reach();
    steps = 2 * longest < kMostSteps ? 1 + static_cast<int>(2 * longest) : kMostSteps;
    finer = s.half / longest;
  }

  /// Brightens texels by the sprite's gain, keeping their hue; none becomes brighter than white.
  MOTES_INLINE void brighten(Texels& t) const {
    if (!(s.gain > 1)) return;
    Floats most{};
    for (int c = 0; c < 3; ++c) {
      const float own = static_cast<float>(s.color >> (8 * c) & 0xffu) * (1.0f / 255);
      most = max(most, to_floats(t.channel[c]) * own);
    }
    const Floats white = to_floats(t.channel[3]);
    const Floats by = max(min(white / max(most, all(1.0f)), all(s.gain)), all(1.0f));
    for (int c = 0; c < 3; ++c) {
      t.channel[c] = max_ints(t.channel[c], to_ints(min(to_floats(t.channel[c]) * by + 0.5f, white)));
    }
  }

  /// Returns the light that a picture sends to the eye, per alpha. (x, y): px from the middle.
  MOTES_INLINE Floats3 shown(const Texels& t, Floats x, Floats y) const {
    const Floats per = 1.0f / max(to_floats(t.channel[3]), all(1.0f));
    const SurfacePoint at = self().point(x, y);
    Floats3 color{to_floats(t.channel[0]) * per * own.x, to_floats(t.channel[1]) * per * own.y,
                  to_floats(t.channel[2]) * per * own.z};
    if (light->lit) color = light_of_surface(*light, at, color);
    return through_fog(*light, color, at.place);
  }

  /// Applies light or gain to texels; none becomes brighter than white.
  MOTES_INLINE void dress(Texels& t, Floats x, Floats y) const {
    if (light == nullptr) return brighten(t);
    if (!any(t.channel[3] > 0)) return;
    const Floats3 color = at_most_white(shown(t, x, y)) * to_floats(t.channel[3]);
    t.channel[0] = to_ints(color.x + 0.5f);
    t.channel[1] = to_ints(color.y + 0.5f);
    t.channel[2] = to_ints(color.z + 0.5f);
  }

  MOTES_INLINE Front front_of(const Texels& t, Floats x, Floats y) const {
    Front front;
    const Floats opacity = to_floats(t.channel[3]), alpha = max(opacity, all(least));
    front.covered = (opacity >= least) & (opacity > 0.0f);  // a picture without any alpha covers nothing
    front.nearer = Floats{};
    front.surface = Uints{};
    if (light != nullptr) {
      if (any(front.covered)) front.surface = surface_of(shown(t, x, y));
      return front;
    }
    Texels bright = t;
    brighten(bright);
    for (int c = 0; c < 3; ++c) {
      const Floats from = all(static_cast<float>(s.color >> (8 * c) & 0xffu));
      front.surface |= (Uints)to_ints(min(from * to_floats(bright.channel[c]) / alpha, all(255.0f)) + 0.5f) << (8 * c);
    }
    front.surface |= 0xff000000u;
    return front;
  }

  /// The part of the streak where the picture may reach a pixel: position of the first sample and the step between
  /// samples, px.
  struct StreakSamples {
    Floats first, step;
  };
  MOTES_INLINE StreakSamples stretch(Floats x, Floats y) const {
    const float far = self().reach();
    const Floats along = x * s.along_x + y * s.along_y;
    const Floats begin = clamp(along - far, -s.half, s.half), end = clamp(along + far, -s.half, s.half);
    const Floats step = (end - begin) * (1 / static_cast<float>(steps));
    return {begin + step * 0.5f, step};
  }
  MOTES_INLINE Texels texels_at(Floats x, Floats y, const StreakSamples& at, int i) const {
    const Floats along = at.first + at.step * static_cast<float>(i);
    return self().texels(x - along * s.along_x, y - along * s.along_y);
  }

  /// Returns the mean over the streak.
  MOTES_INLINE Texels mean(Floats x, Floats y) const {
    if (!moves) return self().texels(x, y);
    const StreakSamples at = stretch(x, y);
    Texels sum{};
    for (int i = 0; i < steps; ++i) {
      const Texels t = texels_at(x, y, at, i);
      for (int c = 0; c < 4; ++c) sum.channel[c] += t.channel[c];
    }
    const Floats part = at.step * (0.5f / s.half * finer);
    for (Ints& channel : sum.channel) channel = to_ints(to_floats(channel) * part + 0.5f);
    return sum;
  }

  MOTES_INLINE Texels most_opaque(Floats x, Floats y) const {
    const StreakSamples at = stretch(x, y);
    Texels most{};
    for (int i = 0; i < steps; ++i) {
      const Texels t = texels_at(x, y, at, i);
      const Mask more = (Mask)(t.channel[3] > most.channel[3]);
      for (int c = 0; c < 4; ++c) most.channel[c] = select(more, t.channel[c], most.channel[c]);
    }
    return most;
  }

  /// Returns the part of a pixel that lies between two edges `apart` px from each other; from_middle: distance of the
  /// pixel from the middle between them.
  static MOTES_INLINE Floats covered(Floats from_middle, float apart) {
    return clamp(0.5f * apart + 0.5f - max(from_middle, -from_middle), 0, apart < 1 ? apart : 1);
  }

  /// Returns the texels at a position relative to the middle, px.
  MOTES_INLINE Texels texels_near(Floats to_right, Floats to_below) const {
    const auto columns = static_cast<float>(level.width), rows = static_cast<float>(level.height);
    // Columns and rows count from the centre of the frame's first texel.
    const Floats column = clamp(to_right * across + (0.5f * columns + 0.5f), 1, columns);
    const Floats row = clamp(to_below * down + (0.5f * rows + 0.5f), 1, rows);
    Texels t = between(level.texels, column, row);
    if (part == 0) return t;
    const Texels other = between(next, column, row);
    for (int c = 0; c < 4; ++c) t.channel[c] += ((other.channel[c] - t.channel[c]) * part + 128) >> 8;
    return t;
  }

 private:
  friend Kind;

  static constexpr float kPart = 1.0f / (1 << image::kTileNumberBits);

  const image::ImageLevel *tile_levels, *next_levels = nullptr;

  MOTES_INLINE Picture(const image::WideSplat& all, const image::PictureSplat& task, const WideSprite& sprite)
      : s(sprite), moves(s.half >= 0.5f), light(all.light), own(color_times(s.color, s.gain)),
        tile_levels(task.levels) {
    if (light != nullptr) s.color |= 0xffffffu;
    cover = task.cover[0];
    if (task.tiles > 1) choose_tile(task);
  }

  MOTES_INLINE void choose_tile(const image::PictureSplat& task) {
    const std::uint32_t number = s.tile;
    const auto count = static_cast<std::uint32_t>(task.tiles);
    std::uint32_t tile = number >> image::kTileNumberBits;
    if (tile >= count) tile = 0;
    const std::uint32_t after = tile + 1 < count ? tile + 1 : 0;
    part = static_cast<int>(number & ((1u << image::kTileNumberBits) - 1));
    tile_levels = task.levels + tile * static_cast<std::uint32_t>(task.level_count);
    next_levels = task.levels + after * static_cast<std::uint32_t>(task.level_count);
    cover = task.cover[tile];
    if (part != 0) cover += (task.cover[after] - cover) * (static_cast<float>(part) * kPart);
  }

  /// Interpolates bilinearly between four texels; weights have the scale of Patch.
  MOTES_INLINE Texels between(const std::uint16_t* texels, Floats at_column, Floats at_row) const {
    constexpr int kOne = 1 << kPartBits;
    const Ints column = to_ints(at_column * float{kOne}), row = to_ints(at_row * float{kOne});
    const Ints first_column = min_ints(column >> kPartBits, all_ints(level.width));
    const Ints first_row = min_ints(row >> kPartBits, all_ints(level.height));
    const Ints right = column - (first_column << kPartBits), below = row - (first_row << kPartBits);
    // Packs the weights of the left and right texel into the lower and upper half of each lane.
    const Ints pair = (kOne - right) | right << 16;
    const int stride = 4 * (level.width + 2);
    std::int32_t index[kLanes];
    store_mask(index, first_row * stride + first_column * 4);
    Texels sum{};
    add_row(sum, texels, index, pair * (kOne - below));
    add_row(sum, texels + stride, index, pair * below);
    for (Ints& channel : sum.channel) channel >>= 15;
    return sum;
  }

  /// Adds, per lane and channel, two neighbouring texels from its index on, times their weights.
  static MOTES_INLINE void add_row(Texels& sum, const std::uint16_t* texels, const std::int32_t (&index)[kLanes],
                                   Ints weights) {
    const FourWords pairs = load_pairs([&](std::size_t lane) { return texels + index[lane]; });
    for (int c = 0; c < 4; ++c) sum.channel[c] += pair_products((Ints)pairs.word[c], weights);
  }
};

struct Image : Picture<Image> {
  using Splat = image::ImageSplat;
  static constexpr float kNarrow = 8;

  MOTES_INLINE Image(const image::WideSplat& task, const WideSprite& sprite)
      : Picture(task, task.own<Splat>(), sprite), at(place_of(task, s)) {
    // Smaller levels, and sides below a pixel, are less opaque than the picture: lower the threshold so that they do
    // not vanish.
    const float opaque = choose_level(task.own<Splat>(), s.radius, 1);
    least = 0.5f * kPixelWeight * opaque * (width < 1 ? width : 1) * (height < 1 ? height : 1);
    choose_steps();
  }
  /// Returns half the diagonal of a square around the picture, half a pixel larger on each side, px.
  MOTES_INLINE float reach() const { return 1.4143f * ((width > height ? width : height) * 0.5f + 0.5f); }
  MOTES_INLINE float box_x() const { return box(size_of(s.up_y), size_of(s.up_x)); }
  MOTES_INLINE float box_y() const { return box(size_of(s.up_x), size_of(s.up_y)); }

  MOTES_INLINE void weigh(Patch<4>& p) const { weigh_still(p); }
  MOTES_INLINE float total() const { return 4 * s.radius * s.radius * cover * s.light; }
  MOTES_INLINE const image::ImageLevel* levels() const { return tile_levels; }
  /// Returns the expected sum of the weights.
  MOTES_INLINE float usual_sum() const { return 4 * s.radius * s.radius * cover * kPixelWeight * finer; }

  /// Covers the pixels where the picture is at least half opaque, taking the most opaque sample along the streak.
  MOTES_INLINE Front front(Floats x, Floats y) const {
    return front_of(moves ? most_opaque(x, y) : texels(x, y), x, y);
  }

 private:
  friend struct Picture<Image>;

  Float3 at;  // place of its middle

  MOTES_INLINE SurfacePoint point(Floats, Floats) const { return {all3(at), Floats3{}}; }

  /// Returns half the extent of the rotated picture along one axis; of_width, of_height: components of its sides'
  /// directions along it.
  MOTES_INLINE float box(float of_width, float of_height) const {
    return of_width * (0.5f * width + 0.5f) + of_height * (0.5f * height + 0.5f);
  }

  /// Returns the picture at pixels (x, y) relative to its middle. Edges are one pixel wide however large the texels;
  /// thin pictures keep their light at any sub-pixel position.
  MOTES_INLINE Texels texels(Floats x, Floats y) const {
    // The picture's x is a quarter turn to the right of `up`.
    const Floats to_right = y * s.up_x - x * s.up_y, to_below = -(x * s.up_x + y * s.up_y);
    Texels t = texels_near(to_right, to_below);
    const Ints part = to_ints(covered(to_right, width) * covered(to_below, height) * 32768.0f + 0.5f);
    for (Ints& channel : t.channel) channel = channel * part >> 15;
    return t;
  }
};

}  // namespace motes::MOTES_ISA
