// Small images that do not move, drawn from stamps: see ImageStamp.
#pragma once

#include <cstdint>

#include "image/raster/kind_image.h"
#include "image/raster/stamps.h"

namespace motes::MOTES_ISA {

/// Returns whether the record of an image is drawn from a stamp.
MOTES_INLINE bool has_stamp(const image::WideSplat& task, const image::WideRecord& r) {
  constexpr int kWidest = static_cast<int>(image::kStampedImage) << image::kSizeBits, kMoves = 1 << image::kWideBits;
  if (task.light != nullptr) return false;
  if (task.memory.image_stamps == nullptr || r.size > kWidest || (r.gain_low | r.gain_high) != 0) return false;
  return std::int64_t{r.dx} * r.dx + std::int64_t{r.dy} * r.dy < kMoves * kMoves;
}

/// The direction of a record's `up`. It begins as upwards, the direction of an unknown `up`.
struct Directed {
  static constexpr int kUpwards = 192;

  int up_x = 0, up_y = 0, direction = kUpwards;
};

/// What the stamp of a small image depends on, except its picture.
struct SmallImage {
  int size, phase_x, phase_y, direction;  // 1/8 px; 1/4 px; see direction_of()
  std::uint32_t tile;                     // tile number, rounded to 1/16
  std::uint32_t look;                     // kOpaque, or 0 for light
  int column, row;                        // pixel of its middle

  static constexpr int kQuarter = 64;  // directions from one axis to the next
  static constexpr std::uint32_t kOpaque = 1u << 31;

  /// `directed`: the previous record's direction, reused because most particles of a system have the same.
  MOTES_INLINE SmallImage(const image::WideSplat& task, const image::WideRecord& r, const unsigned char* bytes,
                          Directed& directed, std::uint32_t as)
      : look(as) {
    size = (r.size + 4) >> (image::kSizeBits - 3);
    const int x = r.x - task.origin_x, y = r.y - task.origin_y;
    column = x >> image::kWideBits;
    row = y >> image::kWideBits;
    phase_x = x >> (image::kWideBits - 2) & 3;
    phase_y = y >> (image::kWideBits - 2) & 3;
    if (r.up_x != directed.up_x || r.up_y != directed.up_y)
      directed = Directed{r.up_x, r.up_y, direction_of(r.up_x, r.up_y)};
    direction = directed.direction;
    tile = 0;
    if (task.form.tile == 0) return;
    __builtin_memcpy(&tile, bytes + task.form.tile, sizeof tile);
    constexpr std::uint32_t kStep = 1u << (image::kTileNumberBits - 4);
    tile = (tile + kStep / 2) & ~(kStep - 1);
  }
  MOTES_INLINE std::uint32_t key() const {
    return look | static_cast<std::uint32_t>(size << 12 | direction << 4 | phase_y << 2 | phase_x);
  }
  MOTES_INLINE std::uint32_t place() const {
    return ((key() & 0xfffu) + static_cast<std::uint32_t>(size) * 0x610u + tile * 0x3d1u) & (image::kImageStamps - 1);
  }
  MOTES_INLINE int part() const { return static_cast<int>(tile & ((1u << image::kTileNumberBits) - 1)); }
  MOTES_INLINE const image::ImageLevel* levels(const image::WideSplat& task) const {
    const auto& picture = task.own<image::ImageSplat>();
    const std::uint32_t number = tile >> image::kTileNumberBits;
    return picture.levels + (number < static_cast<std::uint32_t>(picture.tiles) ? number : 0) *
                                static_cast<std::uint32_t>(picture.level_count);
  }
  /// Returns the slot of the stamp, and in `there` whether the slot holds it already. If not, labels the slot with this
  /// stamp, which the caller must then fill.
  MOTES_INLINE image::ImageStamp& stamp(const image::WideSplat& task, bool& there) const {
    image::ImageStamp& kept = task.memory.image_stamps[place()];
    const image::ImageLevel* own = levels(task);
    there = kept.levels == own && kept.key == key() && kept.part == part();
    kept.levels = own;
    kept.key = key();
    kept.part = part();
    return kept;
  }
  /// Returns the sprite that the stamp shows, with its middle in the first pixel.
  MOTES_INLINE WideSprite stamped(const WideSprite& sprite) const {
    WideSprite s = sprite;
    s.x = (static_cast<float>(phase_x) + 0.5f) * 0.25f;
    s.y = (static_cast<float>(phase_y) + 0.5f) * 0.25f;
    s.radius = static_cast<float>(size) * (1.0f / 16);
    s.half = 0;
    s.light = 1;
    s.tile = tile;
    float x = static_cast<float>(kQuarter - (direction & (kQuarter - 1))), y = static_cast<float>(kQuarter) - x;
    const float scale = 1 / __builtin_sqrtf(x * x + y * y);
    for (int turns = direction / kQuarter; turns > 0; --turns) {
      const float before = x;
      x = -y;
      y = before;
    }
    s.up_x = x * scale;
    s.up_y = y * scale;
    return s;
  }

 private:
  /// Returns the nearest of 4 * kQuarter directions, which divide the sides of the square |x| + |y| = 1 equally.
  static MOTES_INLINE int direction_of(int up_x, int up_y) {
    if (up_x == 0 && up_y == 0) return Directed::kUpwards;
    const auto x = static_cast<float>(up_x), y = static_cast<float>(up_y);
    const float part = size_of(y) / (size_of(x) + size_of(y));
    const int along = static_cast<int>(part * kQuarter + 0.5f);
    const int from_right = x >= 0 ? along : 2 * kQuarter - along;
    return (y >= 0 ? from_right : 4 * kQuarter - from_right) & (4 * kQuarter - 1);
  }
};

/// Half a vector of 32-bit words, and the same bytes as 16-bit numbers.
using StampWords = std::uint32_t __attribute__((vector_size(2 * MOTES_LANES)));
using HalfWords = std::uint16_t __attribute__((vector_size(2 * MOTES_LANES)));

/// A record's colour as factors for pixels of stamps: red and blue, and green, in the order of a surface's bytes.
struct OwnColor {
  HalfWords red_blue, green;

  MOTES_INLINE explicit OwnColor(std::uint32_t color)
      : red_blue((HalfWords)(StampWords{} + (color & 0xff00ffu))),
        green((HalfWords)(StampWords{} + ((color >> 8 & 0xffu) | 0xff0000u))) {}  // 255 keeps the shade

  MOTES_INLINE StampWords times(StampWords surface) const {
    const StampWords odd = (StampWords)product((HalfWords)(surface >> 8 & 0xff00ffu), green);
    return (StampWords)product((HalfWords)(surface & 0xff00ffu), red_blue) | odd << 8;
  }

 private:
  /// Returns a b / 255, rounded.
  static MOTES_INLINE HalfWords product(HalfWords a, HalfWords b) {
    const HalfWords both = a * b + 128;
    return (both + (both >> 8)) >> 8;
  }
};

/// Sets up the part of a small image and stores its position in the stamp.
MOTES_INLINE void place_stamp(const Image& kind, PatchPart& part, image::ImageStamp& stamp) {
  const Outline o = outline_of(kind.s, kind.reach(), kind.box_x(), kind.box_y());
  place_rows(part, kind.s, o, o.first, o.last, 0, o.strips);
  stamp.rows = static_cast<std::uint8_t>(part.rows);
  stamp.strips = static_cast<std::uint8_t>(part.strips);
  stamp.first = static_cast<std::int8_t>(part.first);
  stamp.left = static_cast<std::int8_t>(part.start[0]);
}

/// Computes the stamp of an opaque image.
MOTES_OUTLINE void fill_opaque(const image::WideSplat& task, WideSprite sprite, const SmallImage& small,
                               image::ImageStamp& stamp) {
  sprite.color = 0xffffff;
  const Image kind(task, small.stamped(sprite));
  PatchPart part;
  place_stamp(kind, part, stamp);
  for_each_vector(part, [&](Floats x, Floats y, const InPart& at) {
    const Front front = kind.front(x - kind.s.x, y - kind.s.y);
    const Uints surface = (Uints)front.covered & front.surface;
    std::uint32_t* to = stamp.surface + kStrip * (at.strip * image::ImageStamp::kRows + at.row) + at.first;
    __builtin_memcpy(to, &surface, sizeof surface);
  });
  for (int at = 0; at < image::ImageStamp::kRows * part.strips; ++at) {
    unsigned covered = 0;
    const bool within = at % image::ImageStamp::kRows < part.rows;
    for (int i = 0; within && i < kStrip; ++i) covered |= (stamp.surface[kStrip * at + i] != 0 ? 1u : 0u) << i;
    stamp.covered[at] = static_cast<std::uint8_t>(covered);
  }
}

/// Draws a small opaque image from its stamp. (column, row): the pixel of its middle.
MOTES_INLINE void draw_opaque_stamp(const image::TilePlanes& tile, const image::WideSplat& task,
                                    const image::ImageStamp& stamp, const image::WideRecord& r,
                                    const SmallImage& small) {
  const int top = small.row + stamp.first, left = small.column + stamp.left;
  const int begin = top < 0 ? -top : 0, end = top + stamp.rows < task.rows ? stamp.rows : task.rows - top;
  if (begin >= end) return;
  const int right = left + kStrip * stamp.strips - 1;
  if (is_hidden(tile, left, right, top + begin, top + end - 1, ((Floats)all_uints(r.depth))[0])) return;
  std::uint32_t color;
  __builtin_memcpy(&color, r.color, sizeof color);
  const OwnColor own(color);
  const Longs depth = all_longs(image::NearestSurface{r.depth} << 32);
  for (int strip = 0; strip < stamp.strips; ++strip) {
    const int column = left + strip * kStrip;
    if (column <= -kStrip || column >= image::kTile) continue;
    for (int row = begin; row < end; ++row) {
      const int at = strip * image::ImageStamp::kRows + row;
      image::NearestSurface* to = tile.surfaces + static_cast<std::ptrdiff_t>(top + row) * image::kPixelStride + column;
      for (int i = 0; i < kStrip; i += kLongs) {
        StampWords surface;
        __builtin_memcpy(&surface, stamp.surface + kStrip * at + i, sizeof surface);
        keep_nearest(to + i, __builtin_convertvector(own.times(surface), Longs) | depth, stamp.covered[at] >> i);
      }
    }
  }
}

/// Draws a small image from its stamp, like draw_patch(); (column, row): the pixel of its middle.
template <bool kOver, bool kSaturating, bool kTest>
void draw_stamp(const image::TilePlanes& tile, const image::WideSplat& task, const image::ImageStamp& stamp,
                const Tint& tint, int column, int row, std::uint32_t depth) {
  const int top = row + stamp.first, left = column + stamp.left;
  const int begin = top < 0 ? -top : 0, end = top + stamp.rows < task.rows ? stamp.rows : task.rows - top;
  for (int strip = 0; strip < stamp.strips; ++strip) {
    const int at_column = left + strip * kStrip;
    if (static_cast<unsigned>(at_column + kStrip - 1) >= static_cast<unsigned>(task.columns + kStrip - 1)) continue;
    for (int r = begin; r < end; ++r) {
      const int at = kStrip * (strip * image::ImageStamp::kRows + r);
      Eight cover = load_eight(stamp.weights.cover + at), seen{};
      if (kTest) {
        const std::ptrdiff_t pixel = static_cast<std::ptrdiff_t>(top + r) * image::kPixelStride + at_column;
        seen = seen_of(tile.depth + pixel, depth, task.fade);
        cover = cover * seen >> 12;
      }
      const Eight opacity = kOver ? opacity_of(tint, cover) : Eight{};
      std::uint32_t* to = tile.light + static_cast<std::ptrdiff_t>(top + r) * image::kLightStride + 3 * at_column;
      draw_row<4, kOver, kSaturating, kTest>(tint, to, opacity, cover, stamp.weights.light + 3 * at, seen);
    }
  }
}

}  // namespace motes::MOTES_ISA
