// Draws streaks of sprites of one size from stamps (precomputed weights, see Stamp). Positions are rounded to a quarter
// of a pixel, lengths along both axes to whole pixels.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/raster/cover_lanes.h"
#include "image/raster/disc_lanes.h"
#include "image/raster/stamps.h"
#include "simd/quads.h"

namespace motes::MOTES_ISA {

inline constexpr int kPlaceBits = 6;  // shift from 1/256 px to 1/4 px
inline constexpr int kFarthestWay = 32;  // greatest length along an axis of streaks that have stamps, px
inline constexpr int kWays = 2 * kFarthestWay + 1;

/// Calls use(row, column, weight) for each pixel of the tile whose weight, rounded to 1..255, is not 0. The rounding
/// error is carried to the next pixel; otherwise long narrow streaks would lose a hundredth of their light.
template <class Use>
MOTES_INLINE void round_weights(const DiscGroup& g, const Use& use) {
  const float scale = g.unit_light[0] * 255;
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

/// Columns first .. end - 1; initially none.
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
  g.record_x[0] = ((phase & 3) << kPlaceBits) + (1 << (kPlaceBits - 1));
  g.record_y[0] = ((phase >> 2) << kPlaceBits) + (1 << (kPlaceBits - 1));
  g.size[0] = static_cast<std::int32_t>(key >> 16 << task.own<image::DiscSplat>().key_shift);
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

/// Fields of kWidth records, one record per lane.
struct Streaks {
  Uints position, color, depth, size, way;
};

/// The part of one record's stamp that lies in the tile.
struct StampPart {
  int first, left;  // row and column of the tile where its first pair begins
  int pairs;  // of rows
  int strips, strip_bytes;
  int block, column;  // byte offsets, from the first stamp, of its first block and of its first pair's `column`
  int cover;  // index of its first number in Cover::weights
};
template <class Number>
MOTES_INLINE Number begin_of_cover(Number first, Number left) {
  return image::Cover::kPairStride * ((first + 1) >> 1) + image::Cover::kOddRows * (first & 1) + 2 * left;
}

/// The stamps that kWidth records need, and their positions in the tile.
struct StampUses {
  alignas(64) std::uint32_t color[kWidth], depth[kWidth], size[kWidth], key[kWidth];
  alignas(64) std::int32_t middle_row[kWidth], middle_column[kWidth], place[kWidth], stamp[kWidth];

  /// The StampPart of each record that has a stamp, field by field.
  alignas(64) std::int32_t first[kWidth], left[kWidth], pairs[kWidth], strips[kWidth], strip_bytes[kWidth];
  alignas(64) std::int32_t block[kWidth], column[kWidth], cover[kWidth];
  std::uint32_t most;  // sum over records of the greatest weight
  bool simple;  // all records have a stamp that lies within the tile's margin
  bool narrow;  // all stamps are narrow

  MOTES_INLINE StampPart part(int k) const {
    return {first[k], left[k], pairs[k], strips[k], strip_bytes[k], block[k], column[k], cover[k]};
  }
};
/// Pixels that may be drawn beside the tile on either side: they land in the margins of this row and the next.
inline constexpr int kReach = 2 * image::kMargin;

inline constexpr std::uint32_t kNoStamp = 0;  // StampUses::key of a streak that is too long for a stamp

/// Reads one record per lane from at(lane). Words of a record (those in brackets only if the form has them):
///
///   position [color] [depth] size|light way (dx, dy)
template <class At>
MOTES_INLINE Streaks read_streaks(const image::WideSplat& task, const At& at) {
  const image::RecordForm& form = task.form;
  if (form.color == 0) {
    const Uints color = all_uints(task.color);
    const FourWords all = form.depth == 0 ? load_threes(at) : load_fours(at);
    if (form.depth == 0) return {all.word[0], color, all.word[0], all.word[1], all.word[2]};
    return {all.word[0], color, all.word[1], all.word[2], all.word[3]};
  }
  const FourWords first = load_fours(at);
  if (form.depth == 0) return {first.word[0], first.word[1], first.word[0], first.word[2], first.word[3]};
  const FourWords last = load_fours([&](std::size_t lane) { return at(lane) + 4; });
  return {first.word[0], first.word[1], first.word[2], last.word[2], last.word[3]};
}

/// Finds the stamp of each record. The 16 stamps of one direction and length are adjacent; streaks of up to 15 pixels
/// never collide in the table.
MOTES_INLINE void find_stamps(const image::WideSplat& task, const Streaks& streaks, StampUses& uses, Mask used) {
  const auto first_of = [](Ints pair) { return (Ints)((Uints)pair << 16) >> 16; };
  const int half = 1 << (task.bits - 2), places = image::kWideBits - task.bits;
  const Ints way = (Ints)streaks.way;
  Ints across = (first_of(way) + half) >> (task.bits - 1), down = ((way >> 16) + half) >> (task.bits - 1);
  const Mask known = (max_ints(across, -across) <= kFarthestWay) & (max_ints(down, -down) <= kFarthestWay);
  // A streak and its reverse are the same: make it point down, or right.
  const Ints turn = select(down == 0, across, down) >> 31;
  across = (across ^ turn) - turn;
  down = (down ^ turn) - turn;
  const Ints position = (Ints)streaks.position;
  const Ints x = (Ints)((Uints)first_of(position) << places) - task.origin_x;
  const Ints y = (Ints)((Uints)(position >> 16) << places) - task.origin_y;
  const Ints phase = (x >> kPlaceBits & 3) | (Ints)((Uints)(y >> kPlaceBits & 3) << 2);
  const Ints number = (Ints)((Uints)(down * kWays + across + kFarthestWay) << 4) | phase;
  const Ints size = (Ints)((streaks.size & 0xffffu) >> task.own<image::DiscSplat>().key_shift << 16);
  const Ints key = (number | size) & known, place = (number + (size >> 16) * 0x610) & (image::kStamps - 1);
  const Ints column = x >> image::kWideBits, row = y >> image::kWideBits;
  store_mask(uses.middle_column, column);
  store_mask(uses.middle_row, row);
  store_uints(uses.key, (Uints)key);
  store_mask(uses.place, place);

  const Ints stamp = place * static_cast<int>(sizeof(image::Stamp));
  store_mask(uses.stamp, stamp);
  const auto* stamps = reinterpret_cast<const unsigned char*>(task.memory.stamps);
  const FourWords head = load_fours([&](std::size_t lane) { return stamps + uses.stamp[lane]; });
  const Mask has_stamp = ((Ints)head.word[0] == key) & (key != 0);
  const auto signed_byte = [&](int number) { return (Ints)(head.word[1] << (24 - 8 * number)) >> 24; };
  const Ints top = row + signed_byte(0), left = column + signed_byte(1), right = column + signed_byte(2);
  const Ints strips = (Ints)(head.word[1] >> 24), pairs = (Ints)(head.word[2] & 0xffu);
  uses.most = sum_of((head.word[2] >> 8 & 0xffu) & (Uints)used);
  uses.narrow = !any(used & (Mask)((head.word[2] & 0xff0000u) == 0u));
  const Mask inside = (left >= -kReach) & (right <= image::kTile + kReach);
  uses.simple = !any(used & ~(has_stamp & inside & (strips != 0)));
  const Ints begin = max_ints(-top, Ints{}) >> 1, end = min_ints(pairs, (task.rows + 1 - top) >> 1);
  const Ints first = top + 2 * begin;
  store_mask(uses.first, first);
  store_mask(uses.left, left);
  store_mask(uses.pairs, max_ints(end - begin, Ints{}));
  store_mask(uses.strips, strips);
  store_mask(uses.strip_bytes, image::Stamp::kBlock * pairs);
  store_mask(uses.block, stamp + static_cast<int>(offsetof(image::Stamp, weights)) + image::Stamp::kBlock * begin);
  store_mask(uses.cover, begin_of_cover(first, left));
  store_mask(uses.column, stamp + static_cast<int>(offsetof(image::Stamp, column)) + begin);
}

/// Queues the blocks to draw, in the order of their records, so that one long loop draws them all, however many rows
/// each streak has.
struct BlockQueue {
  /// Capacity: kWidth records x kBlocks, plus 16 slots of over-write.
  static constexpr int kMost = kWidth * image::Stamp::kBlocks + 16;

  int count = 0;
  bool tested = false;  // something may hide some of the records
  bool one_tint = true;
  bool narrow = false;  // all stamps are narrow
  bool covers = false;  // blocks go to the Cover, not to light
  std::uint32_t most = 0;  // sum over records of the greatest weight; used if `covers`
  Tint tints[kWidth];  // one per record; only the first if one_tint
  std::int32_t from[kMost], light[kMost], pixel[kMost], record[kMost];  // pixel, record: filled only when needed
};

/// Returns offsets for eight pairs of rows: from + i * pair + columns[i] * column.
MOTES_INLINE Eight of_pairs(int from, int pair, int column, Eight columns) {
  constexpr Eight kNumbers = {0, 1, 2, 3, 4, 5, 6, 7};
  return kNumbers * static_cast<std::uint32_t>(pair) + columns * static_cast<std::uint32_t>(column) +
         static_cast<std::uint32_t>(from);
}

/// Appends a part's blocks to `count` queued ones and returns the new count. kCovers: queue offsets in the Cover,
/// otherwise in the planes of light (and depth, if tested).
template <bool kCovers>
MOTES_INLINE int queue_part(BlockQueue& queue, int count, const unsigned char* stamps, const StampPart& part, int k) {
  const bool all_planes = !kCovers && (queue.tested || !queue.one_tint);
  int light = part.first * image::kLightStride + 3 * part.left, block = part.block;
  int pixel = part.first * image::kPixelStride + part.left, cover = part.cover;
  for (int strip = part.strips; strip != 0; --strip) {
    int i = 0;
    do {
      const Eight columns = load_eight(stamps + part.column + i);
      const int at = count + i;
      store_words(queue.from + at, of_pairs(block + i * image::Stamp::kBlock, image::Stamp::kBlock, 0, columns));
      if (kCovers) {
        store_words(queue.pixel + at,
                    of_pairs(cover + i * image::Cover::kPairStride, image::Cover::kPairStride, 2, columns));
      } else {
        store_words(queue.light + at,
                    of_pairs(light + i * 2 * image::kLightStride, 2 * image::kLightStride, 3, columns));
      }
      if (all_planes) {
        store_words(queue.pixel + at,
                    of_pairs(pixel + i * 2 * image::kPixelStride, 2 * image::kPixelStride, 1, columns));
        store_words(queue.record + at, eight_of(static_cast<std::uint32_t>(k)));
      }
      i += 8;
    } while (i < part.pairs);
    count += part.pairs;
    light += 3 * kStrip;
    pixel += kStrip;
    cover += 2 * kStrip;
    block += part.strip_bytes;
  }
  return count;
}
MOTES_INLINE void queue_part(BlockQueue& queue, const unsigned char* stamps, const StampPart& part, int k) {
  queue.count = queue.covers ? queue_part<true>(queue, queue.count, stamps, part, k)
                             : queue_part<false>(queue, queue.count, stamps, part, k);
}

MOTES_INLINE void cover_blocks(const image::WideSplat& task, BlockQueue& queue) {
  const auto* stamps = reinterpret_cast<const unsigned char*>(task.memory.stamps);
  image::Cover& cover = *task.memory.cover;
  if (cover.most + queue.most > UINT16_MAX) add_up(cover, task.rows);
  cover.most += queue.most;
  queue.most = 0;
  for (int i = 0; i < queue.count; ++i) add_block(cover.weights + queue.pixel[i], stamps + queue.from[i]);
}

template <bool kOver, bool kSaturating, bool kTest, bool kOneTint, int kUsed = kParts>
MOTES_INLINE void draw_blocks(const image::TilePlanes& tile, const image::WideSplat& task, const BlockQueue& queue,
                              const StampUses& uses) {
  const auto* stamps = reinterpret_cast<const unsigned char*>(task.memory.stamps);
  Tint tint = queue.tints[0];
  tint.shift = image::kStampShift;  // a constant for the compiler
  for (int i = 0; i < queue.count; ++i) {
    const Eight both = load_eight(reinterpret_cast<const std::uint16_t*>(stamps + queue.from[i]));
    if (!kOneTint) {
      const Tint& here = queue.tints[queue.record[i]];
      for (int j = 0; j < (kParts < 3 ? kParts : 3); ++j) tint.part[j] = here.part[j];
      tint.alpha = here.alpha;
    }
    for (int row = 0; row < 2; ++row) {
      Eight cover = (row == 0 ? both & 0xffu : both >> 8) << image::kStampShift;
      if (kTest) {
        const std::uint32_t* walls = tile.depth + queue.pixel[i] + row * image::kPixelStride;
        cover = cover * seen_of(walls, uses.depth[queue.record[i]], task.fade) >> 12;
      }
      const Eight opacity = kOver ? opacity_of(tint, cover) : Eight{};
      draw_row<1, kOver, kSaturating, kTest, 0, kUsed>(tint, tile.light + queue.light[i] + row * image::kLightStride,
                                                       opacity, cover, nullptr, Eight{});
    }
  }
}

/// Draws the queued blocks into the tile's light.
template <bool kOver, bool kSaturating>
void draw_queue(const image::TilePlanes& tile, const image::WideSplat& task, const BlockQueue& queue,
                const StampUses& uses) {
  if (queue.tested) {
    draw_blocks<kOver, kSaturating, true, false>(tile, task, queue, uses);
  } else if (!queue.one_tint) {
    draw_blocks<kOver, kSaturating, false, false>(tile, task, queue, uses);
  } else if (!queue.narrow) {
    draw_blocks<kOver, kSaturating, false, true>(tile, task, queue, uses);
  } else {
    draw_blocks<kOver, kSaturating, false, true, 16 / kWidth>(tile, task, queue, uses);
  }
}
using QueueKernel = void(const image::TilePlanes& tile, const image::WideSplat& task, const BlockQueue& queue,
                         const StampUses& uses);

/// How streaks of one blend are drawn.
struct StreakKernels {
  bool over;  // blended by alpha
  QueueKernel* queue;
};

/// Draws the queued blocks and empties the queue.
MOTES_INLINE void empty(BlockQueue& queue, const image::TilePlanes& tile, const image::WideSplat& task,
                        const StampUses& uses, const StreakKernels& draw) {
  queue.covers ? cover_blocks(task, queue) : draw.queue(tile, task, queue, uses);
  queue.count = 0;
}

/// Queues the stamp of record k, clipped to the tile. Blocks outside are skipped: they would wrap around to the other
/// side, one row lower.
MOTES_INLINE void queue_stamp(const image::WideSplat& task, const StampUses& uses, int k, BlockQueue& queue) {
  const auto* stamps = reinterpret_cast<const unsigned char*>(task.memory.stamps);
  const image::Stamp& stamp = task.memory.stamps[uses.place[k]];
  const int top = uses.middle_row[k] + stamp.first, left = uses.middle_column[k] + stamp.left;
  const int begin = top > 0 ? 0 : -top >> 1, below = (task.rows + 1 - top) >> 1;
  const int end = stamp.pairs < below ? stamp.pairs : below;
  if (begin >= end) return;
  queue.most += stamp.most;
  const int weights = uses.stamp[k] + static_cast<int>(offsetof(image::Stamp, weights));
  const int columns = uses.stamp[k] + static_cast<int>(offsetof(image::Stamp, column));
  const auto part_of = [&](int first, int pairs) {
    return StampPart{top + 2 * first,
                     left,
                     pairs,
                     stamp.strips,
                     image::Stamp::kBlock * stamp.pairs,
                     weights + image::Stamp::kBlock * first,
                     columns + first,
                     begin_of_cover(top + 2 * first, left)};
  };
  if (left >= -kReach && uses.middle_column[k] + stamp.right <= image::kTile + kReach) {
    return queue_part(queue, stamps, part_of(begin, end - begin), k);
  }
  for (int pair = begin; pair < end; ++pair) {
    StampPart part = part_of(pair, 1);
    part.strips = 1;
    for (int strip = 0; strip < stamp.strips;
         ++strip, part.left += kStrip, part.cover += 2 * kStrip, part.block += part.strip_bytes) {
      const int column = part.left + stamp.column[pair];
      if (column > -kStrip && column < task.columns) queue_part(queue, stamps, part, k);
    }
  }
}

/// Draws records one by one, in order, because some have no stamp yet or cannot have one.
template <class DrawAlone>
__attribute__((noinline)) void draw_one_by_one(const image::TilePlanes& tile, const image::WideSplat& task,
                                               const StampUses& uses, int count, BlockQueue& queue, DiscGroup& g,
                                               const StreakKernels& draw, const DrawAlone& draw_alone) {
  for (int k = 0; k < count; ++k) {
    image::Stamp& stamp = task.memory.stamps[uses.place[k]];
    if (uses.key[k] != kNoStamp && stamp.key != uses.key[k]) {
      empty(queue, tile, task, uses, draw);  // queued blocks may refer to the stamp that fill() replaces
      fill(task, uses.key[k], g, stamp);
    }
    if (uses.key[k] != kNoStamp && stamp.usable()) {
      if (!tile.hides || uses.depth[k] <= tile.farthest) queue_stamp(task, uses, k, queue);
      continue;
    }
    empty(queue, tile, task, uses, draw);
    draw_alone(k);
  }
  empty(queue, tile, task, uses, draw);
}

/// Returns whether weights of this colour are accumulated in the Cover first.
MOTES_INLINE bool covers_tile(const image::WideSplat& task, std::uint32_t color, std::uint32_t light) {
  return task.memory.cover != nullptr && task.memory.cover->color == color && task.memory.cover->light == light;
}

template <bool kCovers>
MOTES_INLINE void queue_all(BlockQueue& queue, const image::WideSplat& task, const StampUses& uses, int count) {
  const auto* stamps = reinterpret_cast<const unsigned char*>(task.memory.stamps);
  int blocks = 0;
  for (int k = 0; k < count; ++k) blocks = queue_part<kCovers>(queue, blocks, stamps, uses.part(k), k);
  queue.count = blocks;
}

/// Draws `count` <= kWidth records; calls draw_alone(k) for those without a stamp.
template <class DrawAlone>
MOTES_INLINE void draw_streaks(const image::TilePlanes& tile, const image::WideSplat& task, const Streaks& streaks,
                               int count, StampUses& uses, BlockQueue& queue, DiscGroup& g, const Channels& channel,
                               const StreakKernels& draw, const DrawAlone& draw_alone) {
  const Mask used = first_lanes(static_cast<std::size_t>(count));
  find_stamps(task, streaks, uses, used);
  const Uints color = streaks.color, size = streaks.size;
  store_uints(uses.color, color);
  store_uints(uses.size, size);
  store_uints(uses.depth, streaks.depth);
  queue.count = 0;
  queue.one_tint = !any(used & (Mask)((color != color[0]) | (size != size[0])));
  queue.tested = tile.hides && (task.fade > 0 || any(used & (Mask)(streaks.depth > tile.nearest)));
  const bool alike = queue.one_tint && !queue.tested;
  for (int k = 0; k < (alike ? 1 : count); ++k) queue.tints[k] = stamp_tint(channel, uses.color[k], uses.size[k] >> 16);
  queue.covers = !draw.over && alike && covers_tile(task, uses.color[0], uses.size[0] >> 16);
  queue.most = 0;
  if (!uses.simple || queue.tested) {
    queue.narrow = false;
    return draw_one_by_one(tile, task, uses, count, queue, g, draw, draw_alone);
  }
  if (queue.covers) {
    queue.most = uses.most;
    queue_all<true>(queue, task, uses, count);
  } else {
    queue.narrow = uses.narrow;
    queue_all<false>(queue, task, uses, count);
  }
  empty(queue, tile, task, uses, draw);
}

}  // namespace motes::MOTES_ISA
