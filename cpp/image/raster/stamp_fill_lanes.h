// Computes the stamps of streaks.
#pragma once

#include <cstdint>

#include "image/raster/disc_lanes.h"
#include "image/raster/stamps.h"

namespace motes::MOTES_ISA {

inline constexpr int kPlaceBits = 6;     // 1/256 px to 1/4 px
inline constexpr int kFarthestWay = 32;  // px, of streaks that have stamps
inline constexpr int kWays = 2 * kFarthestWay + 1;

/// Calls use(row, column, weight) for each pixel of the tile whose weight, rounded to 1..255, is not 0. The rounding
/// error is carried to the next pixel; otherwise long narrow streaks would lose a hundredth of their light.
template <class Use>
MOTES_INLINE void round_weights(const DiscGroup& g, const Use& use) {
  const float scale = g.unit[0] * 255;
  const int rows = g.last[0] - g.first[0] + 1;
  const int stride = (rows + kRowsAtOnce - 1) / kRowsAtOnce * kRowsAtOnce;
  float rest = 0;
  for (int row = 0; row < rows; ++row) {
    const int column = g.state[0] == kMoving ? g.start[0][row] : g.column[0];
    for (int i = 0; i < kStrip * g.strips[0]; ++i) {
      const std::uint16_t weight = g.weights[0][(i / kStrip * stride + row) * kStrip + i % kStrip];
      if (weight == 0) continue;
      rest += static_cast<float>(weight) * scale;
      const int rounded = static_cast<int>(rest + 0.5f);
      const int kept = rounded > 255 ? 255 : rounded;
      rest -= static_cast<float>(kept);
      if (kept != 0) use(g.first[0] + row, column + i, kept);
    }
  }
}

/// Columns first .. end - 1; empty at first.
struct ColumnRange {
  int first = INT8_MAX, end = INT8_MIN;
  void add(int column) {
    first = column < first ? column : first;
    end = column >= end ? column + 1 : end;
  }
};

/// Stores the group's first streak in an empty stamp.
MOTES_INLINE void keep(const DiscGroup& g, image::Stamp& stamp) {
  ColumnRange all, pair[image::Stamp::kPairs];
  const int first = g.first[0];
  round_weights(g, [&](int row, int column, int) {
    all.add(column);
    pair[(row - first) / 2].add(column);
  });
  const int pairs = (g.last[0] - first) / 2 + 1;
  int widest = 1;
  for (int p = 0; p < pairs; ++p) {
    if (pair[p].first > pair[p].end) pair[p] = {all.first, all.first};  // an empty pair
    widest = pair[p].end - pair[p].first > widest ? pair[p].end - pair[p].first : widest;
  }
  const int strips = (widest + kStrip - 1) / kStrip;
  if (pairs * strips > image::Stamp::kBlocks || all.first > all.end) return;
  stamp.first = static_cast<std::int8_t>(first);
  stamp.pairs = static_cast<std::uint8_t>(pairs);
  stamp.strips = static_cast<std::uint8_t>(strips);
  stamp.left = static_cast<std::int8_t>(all.first);
  stamp.right = static_cast<std::int8_t>(all.first);
  for (int p = 0; p < pairs; ++p) {
    stamp.column[p] = static_cast<std::uint8_t>(pair[p].first - all.first);
    const int right = pair[p].first + kStrip * strips;
    if (right > stamp.right) stamp.right = static_cast<std::int8_t>(right);
  }
  stamp.narrow = strips == 1;
  round_weights(g, [&](int row, int column, int weight) {
    const int p = (row - first) / 2, i = column - pair[p].first;
    const int at = (i / kStrip * pairs + p) * image::Stamp::kBlock + 2 * (i % kStrip) + (row - first) % 2;
    stamp.weights[at] = static_cast<std::uint8_t>(weight);
    if (weight > stamp.most) stamp.most = static_cast<std::uint8_t>(weight);
    if (i >= image::Stamp::kNarrow) stamp.narrow = 0;
  });
}

/// Computes the stamp of a key, with the streak's middle in the tile's first pixel.
inline __attribute__((noinline)) void fill(const image::WideSplat& task, std::uint32_t key, DiscGroup& g,
                                           image::Stamp& stamp) {
  image::WideSplat alone = task;
  alone.origin_x = alone.origin_y = 0;
  alone.columns = alone.rows = image::kTile;
  const image::TilePlanes nothing{};
  const int phase = static_cast<int>(key & 15), way = static_cast<int>(key >> 4 & 0xfff);
  g.at_x[0] = ((phase & 3) << kPlaceBits) + (1 << (kPlaceBits - 1));
  g.at_y[0] = ((phase >> 2) << kPlaceBits) + (1 << (kPlaceBits - 1));
  g.size[0] = static_cast<std::int32_t>(key >> 16 << task.key_shift);
  g.light[0] = image::kAllLight;
  g.dx[0] = (way % kWays - kFarthestWay) << image::kWideBits;
  g.dy[0] = (way / kWays) << image::kWideBits;
  g.color[0] = g.depth[0] = 0;
  prepare(g, nothing, alone, 1);
  stamp = {};
  stamp.key = key;
  if (g.state[0] != kStill && g.state[0] != kMoving) return;
  weigh(g, 1);
  keep(g, stamp);
}

}  // namespace motes::MOTES_ISA
