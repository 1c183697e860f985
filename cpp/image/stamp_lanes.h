// Streaks of sprites that all have the same size, from stamps: weights that are kept and used again. The places of
// such streaks are rounded to a quarter of a pixel, their lengths along both axes to whole pixels.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/cover_lanes.h"
#include "image/disc_lanes.h"
#include "image/stamps.h"

namespace motes::MOTES_ISA {

inline constexpr int kPlaceBits = 6;     // 1/256 px to 1/4 px
inline constexpr int kFarthestWay = 32;  // px, of streaks that have stamps
inline constexpr int kWays = 2 * kFarthestWay + 1;

/// Which stamps a vector of records need, and where they stand: pixels from the tile's first one to that of the
/// streak's middle.
struct StampUses {
  alignas(64) std::uint32_t position[kWidth], color[kWidth], depth[kWidth], size[kWidth], way[kWidth];
  alignas(64) std::int32_t column[kWidth], row[kWidth], place[kWidth];
  alignas(64) std::uint32_t key[kWidth];

  /// Of stamps that have one strip and stand within the tile's margin: what is drawn of them.
  alignas(64) std::int32_t begin[kWidth], rows[kWidth], light[kWidth], pixel[kWidth];
  bool simple;  // all of them are
  bool narrow;  // all of their stamps are
};
/// What is drawn so far beside a tile does no harm: beyond it is the margin on the next row's other side.
inline constexpr int kReach = 2 * image::kMargin;

inline constexpr std::uint32_t kNoStamp = 0;  // StampUses::key: of what is larger than 2 px

MOTES_INLINE void read_streak(const image::RecordForm& form, const unsigned char* bytes, StampUses& uses, int k) {
  __builtin_memcpy(uses.position + k, bytes, 4);
  __builtin_memcpy(uses.color + k, bytes + form.color, 4);
  __builtin_memcpy(uses.depth + k, bytes + form.depth, 4);  // the position, where there is none
  __builtin_memcpy(uses.size + k, bytes + form.size, 4);
  __builtin_memcpy(uses.way + k, bytes + form.way, 4);
}

MOTES_INLINE Ints load_sixteens(const std::int16_t* from) {
#if MOTES_WIDTH == 512
  // The masked form: g++ 12 warns of an uninitialised operand in the plain one.
  return (Ints)_mm512_maskz_cvtepi16_epi32(0xffff, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)));
#elif MOTES_WIDTH == 256
  return (Ints)_mm256_cvtepi16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
#else
  Ints v;
  for (int lane = 0; lane < kWidth; ++lane) v[lane] = from[lane];
  return v;
#endif
}
MOTES_INLINE Ints steps_of(int step) {
  Ints v;
  for (int lane = 0; lane < kWidth; ++lane) v[lane] = lane * step;
  return v;
}

MOTES_INLINE Ints gather(const void* base, Ints offsets) {
#if MOTES_WIDTH == 512
  return (Ints)_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), 0xffff, (__m512i)offsets, base, 1);
#else
  Ints v;
  for (int lane = 0; lane < kWidth; ++lane) {
    std::int32_t value;  // a lane has no address
    __builtin_memcpy(&value, static_cast<const unsigned char*>(base) + offsets[lane], 4);
    v[lane] = value;
  }
  return v;
#endif
}

/// The 16 stamps of one way stand beside each other; ways of up to 15 pixels never share a place.
MOTES_INLINE void find_stamps(const image::WideSplat& task, StampUses& uses, int count) {
  const auto load = [](const std::uint32_t* from) { return load_mask(reinterpret_cast<const std::int32_t*>(from)); };
  const auto first_of = [](Ints pair) { return (Ints)((Uints)pair << 16) >> 16; };
  const int half = 1 << (task.bits - 2), places = image::kWideBits - task.bits;
  const Ints way = load(uses.way);
  Ints across = (first_of(way) + half) >> (task.bits - 1), down = ((way >> 16) + half) >> (task.bits - 1);
  const Mask known = (max_ints(across, -across) <= kFarthestWay) & (max_ints(down, -down) <= kFarthestWay);
  // The same streak the other way round, downwards or to the right.
  const Ints turn = select(down == 0, across, down) >> 31;
  across = (across ^ turn) - turn;
  down = (down ^ turn) - turn;
  const Ints position = load(uses.position);
  const Ints x = (Ints)((Uints)first_of(position) << places) - task.origin_x;
  const Ints y = (Ints)((Uints)(position >> 16) << places) - task.origin_y;
  const Ints phase = (x >> kPlaceBits & 3) | (Ints)((Uints)(y >> kPlaceBits & 3) << 2);
  const Ints number = (Ints)((Uints)(down * kWays + across + kFarthestWay) << 4) | phase;
  const Ints size = (Ints)((Uints)load(uses.size) << 16);
  const Ints key = (number | size) & known, place = (number + (size >> 16) * 0x610) & (image::kStamps - 1);
  const Ints column = x >> image::kWideBits, row = y >> image::kWideBits;
  store_mask(uses.column, column);
  store_mask(uses.row, row);
  store_uints(uses.key, (Uints)key);
  store_mask(uses.place, place);

  const Mask used = steps_of(1) < count;
  const Ints offsets = place * static_cast<int>(sizeof(image::Stamp));
  const auto* stamps = reinterpret_cast<const unsigned char*>(task.stamps);
  const Mask has_stamp = (gather(stamps, offsets) == key) & (key != 0);
  const Ints shape = gather(stamps + offsetof(image::Stamp, first), offsets);
  const Ints parts = gather(stamps + offsetof(image::Stamp, strips), offsets), strips = parts & 0xff;
  uses.narrow = !any(used & ((parts & 0xff00) == 0));
  const auto byte_of = [&](int number) { return (Ints)((Uints)shape << (24 - 8 * number)) >> 24; };
  const Mask inside = (column + byte_of(2) >= -kReach) & (column + byte_of(3) <= image::kTile + kReach);
  uses.simple = !any(used & ~(has_stamp & inside & (strips == 1)));
  const Ints first = row + byte_of(0), begin = min_ints(max_ints(-first, Ints{}), all_ints(image::Stamp::kRows));
  store_mask(uses.begin, begin);
  store_mask(uses.rows, max_ints(min_ints(byte_of(1), task.rows - first) - begin, Ints{}));
  store_mask(uses.light, row * image::kLightStride + 3 * column);
  store_mask(uses.pixel, row * image::kPixelStride + column);
}

/// The weights of light in a footprint's steps. What is rounded off is added to the next pixel that the streak covers,
/// or long narrow ones would lose a hundredth of their light.
MOTES_INLINE void round_weights(const DiscGroup& g, int rows, int stride, image::Stamp& stamp) {
  const float scale = g.unit[0] * 255;
  float rest = 0;
  for (int row = 0; row < rows; ++row) {
    for (int strip = 0; strip < stamp.strips; ++strip) {
      for (int i = 0; i < kStrip; ++i) {
        const std::uint16_t weight = g.weights[0][(strip * stride + row) * kStrip + i];
        if (weight != 0) rest += static_cast<float>(weight) * scale;
        const int rounded = weight == 0 ? 0 : static_cast<int>(rest + 0.5f);
        const int kept = rounded > 255 ? 255 : rounded;
        rest -= static_cast<float>(kept);
        stamp.weights[(strip * rows + row) * kStrip + i] = static_cast<std::uint8_t>(kept);
        if (i >= image::Stamp::kNarrow && kept != 0) stamp.narrow = 0;
      }
    }
  }
}

/// Computes a stamp, with the streak's middle in the first pixel of a large tile.
inline __attribute__((noinline)) void fill(const image::WideSplat& task, std::uint32_t key, DiscGroup& g,
                                           image::Stamp& stamp) {
  image::WideSplat alone = task;
  alone.origin_x = alone.origin_y = 0;
  alone.columns = alone.rows = image::kTile;
  const image::TilePlanes nothing{};
  const int phase = static_cast<int>(key & 15), way = static_cast<int>(key >> 4 & 0xfff);
  g.at_x[0] = ((phase & 3) << kPlaceBits) + (1 << (kPlaceBits - 1));
  g.at_y[0] = ((phase >> 2) << kPlaceBits) + (1 << (kPlaceBits - 1));
  g.size[0] = static_cast<std::int32_t>(key >> 16);
  g.light[0] = image::kAllLight;
  g.dx[0] = (way % kWays - kFarthestWay) << image::kWideBits;
  g.dy[0] = (way / kWays) << image::kWideBits;
  g.color[0] = g.depth[0] = 0;
  prepare(g, nothing, alone, 1);
  stamp.key = key;
  const int rows = g.last[0] - g.first[0] + 1;
  const int stride = (rows + kRowsAtOnce - 1) / kRowsAtOnce * kRowsAtOnce;
  stamp.strips = 0;
  if ((g.state[0] != kStill && g.state[0] != kMoving) || rows * g.strips[0] > image::Stamp::kRows) return;
  weigh(g, 1);
  stamp.first = static_cast<std::int8_t>(g.first[0]);
  stamp.rows = static_cast<std::int8_t>(rows);
  stamp.strips = static_cast<std::uint8_t>(g.strips[0]);
  stamp.narrow = stamp.strips == 1;
  stamp.left = INT8_MAX;
  stamp.right = INT8_MIN;
  for (int row = 0; row < rows; ++row) {
    const int column = g.state[0] == kMoving ? g.start[0][row] : g.column[0], end = column + kStrip * stamp.strips;
    stamp.lane[row] = static_cast<std::int16_t>((g.first[0] + row) * image::kLightStride + 3 * column);
    stamp.pixel[row] = static_cast<std::int16_t>((g.first[0] + row) * image::kPixelStride + column);
    if (column < stamp.left) stamp.left = static_cast<std::int8_t>(column);
    if (end > stamp.right) stamp.right = static_cast<std::int8_t>(end);
  }
  round_weights(g, rows, stride, stamp);
}

/// The rows of stamps that are to be drawn, in the order of their records: drawn in one loop, whose length does not
/// depend on how many rows each streak has.
struct RowQueue {
  static constexpr int kMost = kWidth * image::Stamp::kRows;

  int count = 0;
  bool tested = false;  // some of the records may be hidden
  bool one_tint = true;
  bool narrow = false;  // all rows are
  Tint tints[kWidth];  // of the records; if they are equal, the first one counts
  alignas(64) std::int32_t light[kMost + kWidth], pixel[kMost + kWidth], weights[kMost + kWidth],
      record[kMost + kWidth];
};

template <bool kOver, bool kSaturating, bool kTest, bool kOneTint, int kUsed = kParts>
MOTES_INLINE void draw_rows(const image::TilePlanes& tile, const image::WideSplat& task, const RowQueue& queue,
                            const StampUses& uses) {
  const auto* weights = reinterpret_cast<const std::uint8_t*>(task.stamps);
  Tint tint = queue.tints[0];
  tint.shift = image::kStampShift;  // the compiler knows this one
  for (int i = 0; i < queue.count; ++i) {
    Eight cover = load_eight(weights + queue.weights[i]) << image::kStampShift;
    if (!kOneTint) {
      const Tint& here = queue.tints[queue.record[i]];
      for (int j = 0; j < (kParts < 3 ? kParts : 3); ++j) tint.part[j] = here.part[j];
      tint.alpha = here.alpha;
    }
    if (kTest) cover = cover * seen_of(tile.depth + queue.pixel[i], uses.depth[queue.record[i]], task.fade) >> 12;
    const Eight opacity = kOver ? opacity_of(tint, cover) : Eight{};
    draw_row<1, kOver, kSaturating, kTest, 0, kUsed>(tint, tile.light + queue.light[i], opacity, cover, nullptr,
                                                     Eight{});
  }
}

template <bool kOver, bool kSaturating>
MOTES_INLINE void draw_queue(const image::TilePlanes& tile, const image::WideSplat& task, RowQueue& queue,
                             const StampUses& uses) {
  if (queue.tested) {
    draw_rows<kOver, kSaturating, true, false>(tile, task, queue, uses);
  } else if (!queue.one_tint) {
    draw_rows<kOver, kSaturating, false, false>(tile, task, queue, uses);
  } else if (!queue.narrow) {
    draw_rows<kOver, kSaturating, false, true>(tile, task, queue, uses);
  } else {
    draw_rows<kOver, kSaturating, false, true, 16 / kWidth>(tile, task, queue, uses);
  }
  queue.count = 0;
}

/// Rows begin .. end - 1 of one strip of record k.
MOTES_INLINE void queue_rows(RowQueue& queue, const image::Stamp& stamp, int k, int light, int pixel, int weights,
                             int begin, int end) {
  const int first = queue.count - begin;
  for (int i = begin; i < end; i += kWidth) {
    store_mask(queue.light + first + i, load_sixteens(stamp.lane + i) + light);
    store_mask(queue.weights + first + i, steps_of(kStrip) + (weights + kStrip * i));
    if (queue.one_tint && !queue.tested) continue;
    store_mask(queue.pixel + first + i, load_sixteens(stamp.pixel + i) + pixel);
    store_mask(queue.record + first + i, all_ints(k));
  }
  queue.count += end - begin;
}

MOTES_INLINE void queue_stamp(const image::WideSplat& task, const image::Stamp& stamp, const StampUses& uses, int k,
                              RowQueue& queue) {
  const int column = uses.column[k], row = uses.row[k], first = row + stamp.first;
  const int begin = first > 0 ? 0 : -first;
  const int end = first + stamp.rows <= task.rows ? stamp.rows : task.rows - first;
  int light = row * image::kLightStride + 3 * column, pixel = row * image::kPixelStride + column;
  auto weights = static_cast<int>(stamp.weights - reinterpret_cast<const std::uint8_t*>(task.stamps));
  const bool inside = column + stamp.left >= -kReach && column + stamp.right <= image::kTile + kReach;
  for (int strip = 0; strip < stamp.strips; ++strip) {
    if (inside) {
      if (begin < end) queue_rows(queue, stamp, k, light, pixel, weights, begin, end);
    } else {
      for (int i = begin; i < end; ++i) {
        const int from = stamp.pixel[i] - (stamp.first + i) * image::kPixelStride + column + strip * kStrip;
        if (static_cast<unsigned>(from + kStrip - 1) >= static_cast<unsigned>(task.columns + kStrip - 1)) continue;
        queue_rows(queue, stamp, k, light, pixel, weights, i, i + 1);
      }
    }
    light += 3 * kStrip;
    pixel += kStrip;
    weights += kStrip * stamp.rows;
  }
}

/// One record after another: some have no stamp yet, or cannot have one. The order of all stays as it is.
template <bool kOver, bool kSaturating, class DrawAlone>
__attribute__((noinline)) void draw_one_by_one(const image::TilePlanes& tile, const image::WideSplat& task,
                                               const StampUses& uses, int count, RowQueue& queue, DiscGroup& g,
                                               const DrawAlone& draw_alone) {
  for (int k = 0; k < count; ++k) {
    image::Stamp& stamp = task.stamps[uses.place[k]];
    if (uses.key[k] != kNoStamp && stamp.key != uses.key[k]) {
      draw_queue<kOver, kSaturating>(tile, task, queue, uses);  // it may refer to what is replaced
      fill(task, uses.key[k], g, stamp);
    }
    if (uses.key[k] != kNoStamp && stamp.usable()) {
      if (!tile.hides || uses.depth[k] <= tile.farthest) queue_stamp(task, stamp, uses, k, queue);
      continue;
    }
    draw_queue<kOver, kSaturating>(tile, task, queue, uses);
    draw_alone(k);
  }
  draw_queue<kOver, kSaturating>(tile, task, queue, uses);
}

/// Whether records of this colour are added up first: see Cover.
MOTES_INLINE bool covers_tile(const image::WideSplat& task, std::uint32_t color, std::uint32_t light) {
  return task.cover != nullptr && task.cover->color == color && task.cover->light == light;
}

MOTES_INLINE void cover_queue(const image::WideSplat& task, const RowQueue& queue) {
  const auto* weights = reinterpret_cast<const std::uint8_t*>(task.stamps);
  std::uint32_t* to = task.cover->weights;
  for (int i = 0; i < queue.count; ++i) add_cover(to + queue.pixel[i], load_eight(weights + queue.weights[i]));
}

/// Draws `count` records, at most a vector of them; draw_alone(k) those that have no stamp.
template <bool kOver, bool kSaturating, class DrawAlone>
MOTES_INLINE void draw_streaks(const image::TilePlanes& tile, const image::WideSplat& task, StampUses& uses, int count,
                               RowQueue& queue, DiscGroup& g, const Channels& channel, const DrawAlone& draw_alone) {
  find_stamps(task, uses, count);
  const Mask used = steps_of(1) < count;
  const Uints color = load_uints(uses.color), size = load_uints(uses.size);
  queue.count = 0;
  queue.narrow = false;
  queue.one_tint = !any(used & (Mask)((color != uses.color[0]) | (size != uses.size[0])));
  queue.tested = tile.hides && (task.fade > 0 || any(used & (Mask)(load_uints(uses.depth) > tile.nearest)));
  const bool alike = queue.one_tint && !queue.tested;
  for (int k = 0; k < (alike ? 1 : count); ++k) queue.tints[k] = stamp_tint(channel, uses.color[k], uses.size[k] >> 16);
  if (!uses.simple || !alike) {
    return draw_one_by_one<kOver, kSaturating>(tile, task, uses, count, queue, g, draw_alone);
  }
  queue.narrow = uses.narrow;
  const bool covers = !kOver && covers_tile(task, uses.color[0], uses.size[0] >> 16);
  const std::int32_t* middle = covers ? uses.pixel : uses.light;
  std::int32_t* queued = covers ? queue.pixel : queue.light;
  const Ints weights_of_rows = steps_of(kStrip);
  for (int k = 0; k < count; ++k) {
    const image::Stamp& stamp = task.stamps[uses.place[k]];
    const std::int16_t* row = covers ? stamp.pixel : stamp.lane;
    const int begin = uses.begin[k], rows = uses.rows[k];
    const auto weights = static_cast<int>(stamp.weights - reinterpret_cast<const std::uint8_t*>(task.stamps));
    int done = 0;
    do {
      const int to = queue.count + done, from = begin + done;
      store_mask(queued + to, load_sixteens(row + from) + middle[k]);
      store_mask(queue.weights + to, weights_of_rows + (weights + kStrip * from));
      done += kWidth;
    } while (done < rows);
    queue.count += rows;
  }
  covers ? cover_queue(task, queue) : draw_queue<kOver, kSaturating>(tile, task, queue, uses);
}

}  // namespace motes::MOTES_ISA
