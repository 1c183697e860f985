// Draws discs and their streaks in groups of kWidth records, in three steps over the whole group. A record's steps are
// far apart, so none waits for the one before.
//
//   records -> read_record() -> prepare() -> weigh() -> draw_discs()
//              one per lane     all lanes    one after another: 16-bit weights, 8 px of a row at a time
//
//   prepare    where each disc is, which rows and strips it may light, its state:
//                hidden   beside the tile, or behind all of its surfaces: skipped
//                still    weights from the distance to its middle
//                moving   weights from the distance across the streak and beyond its ends
//                large    more than kRows x kStrips: returned to the caller, which draws it alone (kind_disc.h)
//   weigh      weights of each pixel of its rows, cut into strips of 8 px as in a Patch:
//
//                first  +--------+--------+       a still disc is a box; rows of a streak start where it runs
//                       | strip 0| strip 1|           +--------+
//                 last  +--------+--------+             +--------+
//                                                         +--------+
//   draw       adds weight times tint to the tile's light, if need be only where nothing nearer hides the disc
#pragma once

#include "image/raster/wide_sprite.h"

namespace motes::MOTES_ISA {

/// Profiles of a disc and its streak in fixed point.
struct DiscShape {
  /// A disc's mean light over a streak, c radii across from its line, is (1 - c^2)^2.5; (1 - (kSlim c)^2)^2 is nearly
  /// the same.
  static constexpr float kSlim = 1.1f;
  static constexpr float kStillWeight = 16384,
                         kStreakWeight = 2048;  // greatest weights, still and in motion
  static constexpr float kUnit = 4096;  // fixed-point units per radius: 16 bits reach 8 radii each way
  static constexpr float kFullTurn = 3.14159265f;

  static MOTES_INLINE Ints fixed(Floats v) { return to_ints(clamp(v * kUnit, -32767, 32767)); }
  /// Returns v^2 * 16384 for v * 4096, |v| clamped to 1.
  static MOTES_INLINE Shorts square_of(Shorts v) {
    const Shorts inside = min_shorts(max_shorts(v, all_shorts(-4095)), all_shorts(4095)) << 3;
    return multiply_high(inside, inside);
  }
  /// Returns v^2 * 16384 for v * 16384.
  static MOTES_INLINE Shorts soft(Shorts rest) {
    const Shorts twice = rest + rest;
    return multiply_high_unsigned(twice, twice);
  }
  static MOTES_INLINE Shorts still(Shorts row, Shorts across) {
    return soft(subtract_to_zero(all_shorts(16384) - square_of(row), across));
  }
  /// Returns a streak's weight from the distance across its line (radii) and beyond both ends of its plateau (lengths
  /// of its ramps), each * 4096.
  static MOTES_INLINE Shorts streak(Shorts side, Shorts one, Shorts other) {
    const Shorts profile = soft(all_shorts(16384) - square_of(side));
    const Shorts beyond = min_shorts(max_shorts(max_shorts(one, other), Shorts{}), all_shorts(4095)) << 3;
    // 1 - t^2 (3 - 2 t), * 2^13
    const Shorts square = multiply_high_unsigned(beyond, beyond + beyond);
    const Shorts less = multiply_high_unsigned(square, all_shorts(49152 - 65536) - beyond);
    return multiply_high_unsigned(profile, all_shorts(8192) - less);
  }
};

/// A group of kWidth records, one per lane.
struct DiscGroup {
  static constexpr int kRows = 32, kStrips = 3;  // largest patch that is drawn in groups
  static constexpr int kPixels = kRows * kStrips * kStrip;
  // Rows drawn of every small disc (one strip): a mispredicted loop end costs more than extra rows of weight 0.
  static constexpr int kSmallRows = 8;
  static constexpr bool kHasSmall = kWidth >= 8;  // narrower vectors lose more by extra rows than they gain

  // Read: as in WideRecord.
  alignas(64) std::int32_t record_x[kWidth], record_y[kWidth], size[kWidth], light[kWidth], dx[kWidth], dy[kWidth];
  alignas(64) std::uint32_t color[kWidth], depth[kWidth];

  // Prepared: where the sprite is, px from the centre of the tile's first pixel, and the pixels that it may light. The
  // row through its middle begins at `left`, each row `slope` px to the right of the one above.
  alignas(64) float x[kWidth], y[kWidth], left[kWidth], slope[kWidth];
  alignas(64) float along_x[kWidth], along_y[kWidth];  // direction of the streak, a unit vector
  alignas(64) float total[kWidth];                     // its light, px^2
  alignas(64) std::int32_t first[kWidth], last[kWidth];       // rows
  alignas(64) std::int32_t column[kWidth], strips[kWidth];  // first column, and strips of kStrip columns from there
  alignas(64) std::int32_t state[kWidth];  // kHidden ...
  alignas(64) std::int32_t small[kWidth];  // mask: a still disc of one strip

  // Prepared: the profile in fixed point (DiscShape::kUnit per radius). Of a still disc, the first pixel's place below
  // and to the right of the middle, and the way from pixel to pixel. Of a streak, ways from column to column, and
  // factors from px: across its line, and beyond its `plateau` (half its length, px) in lengths of the ramp.
  alignas(64) std::int32_t first_down[kWidth], first_right[kWidth], step[kWidth];
  alignas(64) std::int32_t step_across[kWidth], step_along[kWidth];
  alignas(64) float across_per_px[kWidth], ramp_per_px[kWidth], plateau[kWidth];

  // Weighed: weights in the layout of a Patch, their sum, the light of a weight of 1, and the same as a Tint takes it.
  std::uint16_t* weights[kWidth];
  alignas(64) std::uint32_t sum[kWidth];
  alignas(64) float unit_light[kWidth];
  alignas(64) std::uint32_t tint_number[kWidth], tint_shift[kWidth];
  alignas(64) std::int32_t start[kWidth][kRows + kMoreRows];  // of a streak: first column of each row
  alignas(64) std::uint16_t memory[kWidth * kPixels + 64];  // of all weights
};
/// DiscGroup::state. Large ones do not fit into a group's patch: they are drawn alone.
inline constexpr int kHidden = 0, kStill = 1, kMoving = 2, kLarge = 3;

MOTES_INLINE Floats gain_of(const image::DiscSplat& task, Floats diameter) {
  const Floats most = all(static_cast<float>(image::kMaxFootprint));
  const Floats within = min(diameter, most);
  // Lanes without a record may hold anything, so the index is clamped.
  const Ints below = max_ints(min_ints(to_ints(within), all_ints(image::kMaxFootprint - 1)), all_ints(0));
#if MOTES_WIDTH == 512
  const Floats table = load(task.gain);
  const Floats low = pick(table, below), high = pick(table, below + 1);
#else
  Floats low, high;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    low[lane] = task.gain[below[lane]];
    high[lane] = task.gain[below[lane] + 1];
  }
#endif
  return low + (high - low) * (within - to_floats(below));
}

/// Computes everything that follows from the records: position, direction, outline, state.
MOTES_OUTLINE void prepare(DiscGroup& g, const image::TilePlanes& tile, const image::WideSplat& task, int count) {
  constexpr float kUnit = 1.0f / (1 << image::kWideBits);
  const Floats x = to_floats(load_mask(g.record_x) - task.origin_x) * kUnit;
  const Floats y = to_floats(load_mask(g.record_y) - task.origin_y) * kUnit;
  const Floats radius = to_floats(load_mask(g.size)) * (0.5f / (1 << image::kSizeBits));
  const Floats dx = to_floats(load_mask(g.dx)) * kUnit, dy = to_floats(load_mask(g.dy)) * kUnit;
  const Floats length = sqrt(dx * dx + dy * dy);
  const Mask moving = length * 0.5f > radius * kShortest;
  const Floats half = only(moving, length * 0.5f);
  const Floats per_length = 1.0f / select(moving, length, all(1.0f));
  const Floats along_x = select(moving, dx * per_length, all(1.0f)), along_y = only(moving, dy * per_length);
  const Floats per_radius = 1.0f / radius;
  const Floats half_radii = half * per_radius;

  // The outline, as in outline_of().
  const Floats steep = abs(along_y), extent_x = radius + half * abs(along_x), extent_y = radius + half * steep;
  const Floats reach = radius * (1 / DiscShape::kSlim);
  const Mask follows = moving & (reach < steep * extent_x) & (2 * reach < steep * kWideRow);
  const Floats over = select(follows, along_y, all(1.0f));
  const Floats side = select(follows, reach / abs(over), extent_x);
  const Floats left = x - side;
  const Ints first = floor_to_ints(y - extent_y) + 1, last = floor_to_ints(y + extent_y);
  const Ints column = floor_to_ints(left) + 1;
  const Ints strips = (to_ints(2 * side) + kStrip) >> 3;

  Mask seen = (last >= 0) & (first <= task.rows - 1) & (last >= first);
  seen &= (x + extent_x > 0.0f) & (x - extent_x < static_cast<float>(task.columns - 1));
  if (tile.hides) seen &= load_mask(reinterpret_cast<const std::int32_t*>(g.depth)) <= static_cast<int>(tile.farthest);
  seen &= first_lanes(static_cast<std::size_t>(count));
  const Mask small = (last - first < DiscGroup::kRows) & (strips <= DiscGroup::kStrips);
  store_mask(g.state, seen & select(small, select(moving, all_ints(kMoving), all_ints(kStill)), all_ints(kLarge)));

  const Floats light = to_floats(load_mask(g.light)) * (1.0f / image::kAllLight);
  store(g.total,
        radius * radius * (DiscShape::kFullTurn / 3) * light * gain_of(task.own<image::DiscSplat>(), 2 * radius));
  store(g.x, x);
  store(g.y, y);
  store(g.along_x, along_x);
  store(g.along_y, along_y);
  store(g.left, left);
  store(g.slope, only(follows, along_x / over));
  store_mask(g.first, first);
  store_mask(g.last, last);
  store_mask(g.column, column);
  store_mask(g.strips, strips);
  // A still disc of one strip has at most kStrip rows, and the tile's margins hold what falls outside.
  static_assert(DiscGroup::kSmallRows == kStrip && kStrip <= image::kMargin);
  store_mask(g.small, DiscGroup::kHasSmall ? seen & ~moving & (strips == 1) : Mask{});

  const Floats level = max(half_radii - 1.0f, Floats{}), ramp = select(half_radii > 1.0f, all(2.0f), half_radii + 1.0f);
  const Floats narrow = per_radius * DiscShape::kSlim, end = per_radius / ramp;
  store(g.across_per_px, narrow);
  store(g.ramp_per_px, end);
  store(g.plateau, level * radius);
  store_mask(g.step_across, DiscShape::fixed(-along_y * narrow));
  store_mask(g.step_along, DiscShape::fixed(along_x * end));
  store_mask(g.step, DiscShape::fixed(per_radius));
  store_mask(g.first_down, DiscShape::fixed((to_floats(first) - y) * per_radius));
  store_mask(g.first_right, DiscShape::fixed((to_floats(column) - x) * per_radius));
}

MOTES_INLINE void weigh_still(DiscGroup& g, int i, int rows, int strips, std::uint16_t* to) {
  const int step = g.step[i];
  const Shorts across = columns_of_lanes() * all_shorts(step);
  const Shorts next = all_shorts(step * kRowsAtOnce);
  Uints sum{};
  for (int strip = 0; strip < strips; ++strip) {
    const Shorts side =
        DiscShape::square_of(add_saturating(all_shorts(g.first_right[i] + strip * kStrip * step), across));
    Shorts down = rows_of_lanes() * all_shorts(step) + all_shorts(g.first_down[i]);
    for (int row = 0; row < rows; row += kRowsAtOnce, to += kShorts) {
      const Shorts weights = DiscShape::still(down, side);
      store_shorts(to, weights);
      sum += pair_sums(rows_within(weights, row, rows));
      down = add_saturating(down, next);
    }
  }
  g.sum[i] = sum_of(sum);
}

MOTES_INLINE void weigh_streak(DiscGroup& g, int i, std::uint16_t* to) {
  const int rows = g.last[i] - g.first[i] + 1;
  std::int16_t across[DiscGroup::kRows + kMoreRows], after[DiscGroup::kRows + kMoreRows],
      before[DiscGroup::kRows + kMoreRows];
  const Shorts to_side = columns_of_lanes() * all_shorts(g.step_across[i]);
  const Shorts to_end = columns_of_lanes() * all_shorts(g.step_along[i]);
  Uints sum{};
  for (int strip = 0; strip < g.strips[i]; ++strip) {
    for (int row = 0; row < rows; row += kWidth) {
      const Floats y = numbers_from(g.first[i] + row) - g.y[i];
      const Ints start = floor_to_ints(y * g.slope[i] + g.left[i]) + 1;
      if (strip == 0) store_mask(g.start[i] + row, start);
      const Floats x = to_floats(start + strip * kStrip) - g.x[i];
      const Floats along = x * g.along_x[i] + y * g.along_y[i];
      store_narrow(across + row, DiscShape::fixed((y * g.along_x[i] - x * g.along_y[i]) * g.across_per_px[i]));
      store_narrow(after + row, DiscShape::fixed((along - g.plateau[i]) * g.ramp_per_px[i]));
      store_narrow(before + row, DiscShape::fixed((-along - g.plateau[i]) * g.ramp_per_px[i]));
    }
    for (int row = 0; row < rows; row += kRowsAtOnce, to += kShorts) {
      const Shorts weights = DiscShape::streak(add_saturating(by_eights(across + row), to_side),
                                               add_saturating(by_eights(after + row), to_end),
                                               add_saturating(by_eights(before + row), Shorts{} - to_end));
      store_shorts(to, weights);
      sum += pair_sums(rows_within(weights, row, rows));
    }
  }
  g.sum[i] = sum_of(sum);
}

/// Computes the weights of the group's sprites, and their `number` and `shift` for tint_of().
MOTES_OUTLINE void weigh(DiscGroup& g, int count) {
  std::uint16_t* to = g.memory;
  for (int i = 0; i < count; ++i) {
    g.weights[i] = to;
    g.sum[i] = 1;
    if (g.state[i] != kStill && g.state[i] != kMoving) continue;
    const bool small = g.small[i] != 0;
    const int rows = small ? DiscGroup::kSmallRows : g.last[i] - g.first[i] + 1;
    if (small) {
      weigh_still(g, i, DiscGroup::kSmallRows, 1, to);
    } else if (g.state[i] == kStill) {
      weigh_still(g, i, rows, g.strips[i], to);
    } else {
      weigh_streak(g, i, to);
    }
    to += (rows + kRowsAtOnce - 1) / kRowsAtOnce * kShorts * g.strips[i];
  }
  const Floats sum = to_floats((Ints)load_uints(g.sum));
  const Mask still = load_mask(g.state) == kStill;
  const Floats most = select(still, all(image::kMostLight / DiscShape::kStillWeight),
                             all(image::kMostLight / DiscShape::kStreakWeight));
  const Floats unit = min(load(g.total) / max(sum, all(1.0f)), most);
  store(g.unit_light, unit);
  const Uints bits = (Uints)(unit * (65536.0f * image::kUnit / (255.0f * 255.0f)));
  store_uints(g.tint_number, (bits >> 9 & 0x3fffu) | 0x4000u);
  store_uints(g.tint_shift, (14 + 127) - (bits >> 23));
}

template <bool kOver, bool kSaturating, bool kTest>
MOTES_INLINE void draw_in_group(const image::TilePlanes& tile, const image::WideSplat& task, const DiscGroup& g, int i,
                                const Tint& tint) {
  const int rows = g.last[i] - g.first[i] + 1;
  const int stride = (rows + kRowsAtOnce - 1) / kRowsAtOnce * kRowsAtOnce;
  const int begin = g.first[i] > 0 ? 0 : -g.first[i];
  const int end = g.last[i] < task.rows ? rows : task.rows - g.first[i];
  const bool moves = g.state[i] == kMoving;
  for (int strip = 0; strip < g.strips[i]; ++strip) {
    const std::uint16_t* weights = g.weights[i] + kStrip * (strip * stride + begin);
    std::uint32_t* line = tile.light + static_cast<std::ptrdiff_t>(g.first[i] + begin) * image::kLightStride;
    int column = g.column[i] + strip * kStrip;
    for (int row = begin; row < end; ++row, weights += kStrip, line += image::kLightStride) {
      if (moves) column = g.start[i][row] + strip * kStrip;
      if (static_cast<unsigned>(column + kStrip - 1) >= static_cast<unsigned>(task.columns + kStrip - 1)) continue;
      Eight cover = load_eight(weights);
      if (kTest) {
        const std::uint32_t* walls =
            tile.depth + static_cast<std::ptrdiff_t>(g.first[i] + row) * image::kPixelStride + column;
        cover = cover * seen_of(walls, g.depth[i], task.fade) >> 12;
      }
      const Eight opacity = kOver ? opacity_of(tint, cover) : Eight{};
      draw_row<1, kOver, kSaturating, kTest>(tint, line + 3 * column, opacity, cover, nullptr, Eight{});
    }
  }
}

/// Draws a small disc: always kSmallRows rows, unclipped.
template <bool kOver, bool kSaturating>
MOTES_INLINE void draw_small(const image::TilePlanes& tile, const DiscGroup& g, int i, const Tint& tint) {
  const std::uint16_t* weights = g.weights[i];
  std::uint32_t* line = tile.light + static_cast<std::ptrdiff_t>(g.first[i]) * image::kLightStride + 3 * g.column[i];
  for (int row = 0; row < DiscGroup::kSmallRows; ++row, weights += kStrip, line += image::kLightStride) {
    const Eight cover = load_eight(weights), opacity = kOver ? opacity_of(tint, cover) : Eight{};
    draw_row<1, kOver, kSaturating, false>(tint, line, opacity, cover, nullptr, Eight{});
  }
}

template <bool kOver, bool kSaturating>
MOTES_INLINE void draw(const image::TilePlanes& tile, const image::WideSplat& task, const DiscGroup& g, int i,
                       const Channels& channel) {
  if ((g.state[i] != kStill && g.state[i] != kMoving) || g.tint_shift[i] > 30) return;
  const Tint tint = tint_of(channel, g.color[i], g.tint_number[i], static_cast<int>(g.tint_shift[i]));
  if (tile.hides && (task.fade > 0 || g.depth[i] > tile.nearest)) {
    draw_in_group<kOver, kSaturating, true>(tile, task, g, i, tint);
  } else if (g.small[i] != 0) {
    draw_small<kOver, kSaturating>(tile, g, i, tint);
  } else {
    draw_in_group<kOver, kSaturating, false>(tile, task, g, i, tint);
  }
}

/// Draws records i .. count - 1 up to the first large one; returns its index, or `count`.
template <bool kOver, bool kSaturating>
int draw_discs(const image::TilePlanes& planes, const image::WideSplat& task, const DiscGroup& g, int i, int count) {
  const image::TilePlanes tile = planes;
  const Channels channel = channels();
  for (; i < count && g.state[i] != kLarge; ++i) draw<kOver, kSaturating>(tile, task, g, i, channel);
  return i;
}

}  // namespace motes::MOTES_ISA
