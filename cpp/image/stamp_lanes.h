// Streaks of sprites that all have the same size, from stamps: weights that are kept and used again. The places of
// such streaks are rounded to a quarter of a pixel, their lengths along both axes to whole pixels.
#pragma once

#include "image/disc_lanes.h"
#include "image/stamps.h"

namespace motes::MOTES_ISA {

/// Which stamp a record needs, and where it stands: pixels from the tile's first one to that of the streak's middle.
struct StampUse {
  std::uint64_t key;
  int column, row;
};

inline constexpr int kPlaceBits = 6;  // 1/256 px to 1/4 px
inline constexpr int kFarthestWay = 32;  // px, of streaks that have stamps

MOTES_INLINE bool stamp_use(const image::WideSplat& task, const image::WideRecord& r, StampUse& use) {
  int across = (r.dx + 128) >> 8, down = (r.dy + 128) >> 8;
  if (across < -kFarthestWay || across > kFarthestWay || down < -kFarthestWay || down > kFarthestWay) return false;
  if (down < 0 || (down == 0 && across < 0)) {
    across = -across;
    down = -down;
  }
  const int x = r.x - task.origin_x, y = r.y - task.origin_y;
  const int phase = (x >> kPlaceBits & 3) | (y >> kPlaceBits & 3) << 2;
  use.column = x >> image::kWideBits;
  use.row = y >> image::kWideBits;
  use.key = static_cast<std::uint64_t>(r.size) << 32 | static_cast<std::uint32_t>(across + kFarthestWay) << 16 |
            static_cast<std::uint32_t>(down) << 8 | static_cast<std::uint32_t>(phase) | std::uint64_t{1} << 63;
  return true;
}

/// Computes a stamp, with the streak's middle in the first pixel of a large tile.
inline __attribute__((noinline)) void fill(const image::WideSplat& task, std::uint64_t key, DiscGroup& g,
                                           image::Stamp& stamp) {
  image::WideSplat alone = task;
  alone.origin_x = alone.origin_y = 0;
  alone.columns = alone.rows = image::kTile;
  const image::TilePlanes nothing{};
  const int phase = static_cast<int>(key & 15);
  g.at_x[0] = ((phase & 3) << kPlaceBits) + (1 << (kPlaceBits - 1));
  g.at_y[0] = ((phase >> 2) << kPlaceBits) + (1 << (kPlaceBits - 1));
  g.size[0] = static_cast<std::int32_t>(key >> 32 & 0xffff);
  g.light[0] = image::kAllLight;
  g.dx[0] = (static_cast<int>(key >> 16 & 0xff) - kFarthestWay) << image::kWideBits;
  g.dy[0] = static_cast<int>(key >> 8 & 0xff) << image::kWideBits;
  g.color[0] = g.depth[0] = 0;
  prepare(g, nothing, alone, 1);
  stamp.key = key;
  const int rows = g.last[0] - g.first[0] + 1;
  const int stride = (rows + kRowsAtOnce - 1) / kRowsAtOnce * kRowsAtOnce;
  stamp.usable = (g.state[0] == kStill || g.state[0] == kMoving) && rows * g.strips[0] <= image::Stamp::kRows;
  if (!stamp.usable) return;
  weigh(g, 1);
  stamp.first = g.first[0];
  stamp.rows = rows;
  stamp.strips = g.strips[0];
  stamp.number = g.number[0];
  stamp.shift = static_cast<int>(g.shift[0]);
  for (int row = 0; row < rows; ++row) {
    stamp.start[row] = static_cast<std::int8_t>(g.state[0] == kMoving ? g.start[0][row] : g.column[0]);
  }
  for (int strip = 0; strip < stamp.strips; ++strip) {
    for (int i = 0; i < rows * kStrip; ++i) {
      stamp.weights[strip * rows * kStrip + i] = g.weights[0][strip * stride * kStrip + i];
    }
  }
}

MOTES_INLINE const image::Stamp& stamp_of(const image::WideSplat& task, std::uint64_t key, DiscGroup& g) {
  image::Stamp& stamp = task.stamps[key * 0x9e3779b97f4a7c15u >> (64 - image::kStampBits)];
  if (stamp.key != key) fill(task, key, g, stamp);
  return stamp;
}

template <bool kOver, bool kSaturating, bool kTest>
MOTES_INLINE void draw_stamp(const image::TilePlanes& tile, const image::WideSplat& task, const image::Stamp& stamp,
                             const StampUse& use, std::uint32_t depth, const Tint& tint) {
  const int first = use.row + stamp.first;
  const int begin = first > 0 ? 0 : -first;
  const int end = first + stamp.rows <= task.rows ? stamp.rows : task.rows - first;
  for (int strip = 0; strip < stamp.strips; ++strip) {
    const std::uint16_t* weights = stamp.weights + kStrip * (strip * stamp.rows + begin);
    std::uint32_t* line = tile.light + static_cast<std::ptrdiff_t>(first + begin) * image::kLightStride;
    const int from = use.column + strip * kStrip;
    for (int row = begin; row < end; ++row, weights += kStrip, line += image::kLightStride) {
      const int column = from + stamp.start[row];
      if (static_cast<unsigned>(column + kStrip - 1) >= static_cast<unsigned>(task.columns + kStrip - 1)) continue;
      Eight cover = load_eight(weights);
      if (kTest) {
        const std::uint32_t* walls =
            tile.depth + static_cast<std::ptrdiff_t>(first + row) * image::kPixelStride + column;
        cover = cover * seen_of(walls, depth, task.fade) >> 12;
      }
      const Eight opacity = kOver ? opacity_of(tint, cover) : Eight{};
      draw_row<1, kOver, kSaturating, kTest>(tint, line + 3 * column, opacity, cover, nullptr, Eight{});
    }
  }
}

/// False where the record has no stamp.
template <bool kOver, bool kSaturating>
MOTES_INLINE bool draw_streak(const image::TilePlanes& tile, const image::WideSplat& task, const image::WideRecord& r,
                              DiscGroup& g, const Channels& channel) {
  StampUse use;
  if (!stamp_use(task, r, use)) return false;
  const image::Stamp& stamp = stamp_of(task, use.key, g);
  if (!stamp.usable) return false;
  if (tile.hides && r.depth > tile.farthest) return true;
  // What is left of the light: a product of two numbers of 15 bits and more.
  std::uint32_t number = stamp.number * r.light >> 15;
  int shift = stamp.shift;
  if (number == 0) return true;
  const int less = __builtin_clz(number) - 17;
  number <<= less;
  shift += less;
  if (shift > 30) return true;
  std::uint32_t color;
  __builtin_memcpy(&color, r.color, sizeof color);
  const Tint tint = tint_of(channel, color, number, shift);
  if (tile.hides && (task.fade > 0 || r.depth > tile.nearest)) {
    draw_stamp<kOver, kSaturating, true>(tile, task, stamp, use, r.depth, tint);
  } else {
    draw_stamp<kOver, kSaturating, false>(tile, task, stamp, use, r.depth, tint);
  }
  return true;
}

}  // namespace motes::MOTES_ISA
