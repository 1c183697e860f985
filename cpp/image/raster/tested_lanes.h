// Draws additive records of one fixed size in a tile with surfaces. Records in front of everything near them are drawn
// whole, those behind it are skipped; only the others are tested pixel by pixel.
#pragma once

#include "image/balls/ball_lanes.h"
#include "image/raster/depth_blocks.h"
#include "image/raster/point_lanes.h"
#include "image/raster/settle_lanes.h"
#include "image/raster/splat_lanes.h"
#include "simd/squeeze.h"

namespace motes::MOTES_ISA {

// Returns where the weights of footprints begin in their table, see light_table(); of spheres, in the lanes of `there`.
MOTES_INLINE Ints light_weights(const image::Splat& s, const FootprintPositions& at, Mask there) {
  if (s.balls == nullptr) return at.phase * (s.size * s.row_bytes);
  return balls_at(*s.balls, ball_units(*s.balls->look, at.column, at.row, at.phase), there);
}
MOTES_INLINE const std::uint8_t* light_table(const image::Splat& s) {
  return s.balls == nullptr ? s.weights : s.balls->bytes;
}

// Adds a record that nothing hides.
template <int kVectors, bool kSaturating>
MOTES_INLINE void add_open(const image::Splat& s, const RecordLight& light, const std::uint8_t* weights,
                           std::uint32_t* to) {
  if (kWidth * kVectors < 24 && s.size == 2) return add_point<kSaturating>(light, weights, to);
  add_rows<kVectors, kSaturating>(s.size, s.row_bytes, light, weights, to);
}

// Up to kMost records, sorted into those to draw whole and those to test. Sorting has no branches, since depths of
// neighbouring records are unrelated.
struct Among {
  static constexpr std::size_t kMost = 128;

  alignas(64) std::uint32_t position[kMost], depth[kMost];
  // Offsets from the tile's first pixel in the planes, and into the table of weights.
  alignas(64) std::int32_t light[kMost], pixel[kMost], weights[kMost];
  // Numbers of records: nothing hides any of these; something may hide those; those are close to a surface, too.
  std::uint32_t open[kMost], tested[kMost], close[kMost];
  std::size_t opens, testeds;
};

template <bool kFade>
MOTES_INLINE void find_among(const image::TilePlanes& tile, const image::Splat& s, std::size_t i, std::size_t count,
                             Among& some) {
  const FootprintPositions at = places(s, load_uints(some.position + i));
  const Mask inside = touch(at, s.size) & first_lanes(count - i);
  const Ints block = image::DepthBlocks::at(at.column, at.row) & inside;
  const Pair met = gather_pairs(tile.blocks, block + block);
  const Floats depth = (Floats)load_uints(some.depth + i);
  const Mask is_open = kFade ? keeps_all(met.first, depth, s.fade) : (Mask)((Ints)depth <= (Ints)met.first);
  const Mask is_seen = (Ints)depth <= (Ints)met.second;
  store_mask(some.light + i, in_light(at));
  store_mask(some.pixel + i, at.row * image::kPixelStride + at.column);
  store_mask(some.weights + i, light_weights(s, at, inside & is_seen));
  const Uints number = lane_numbers() + static_cast<std::uint32_t>(i);
  some.opens += squeeze(some.open + some.opens, number, inside & is_open);
  some.testeds += squeeze(some.tested + some.testeds, number, inside & ~is_open & is_seen);
}

template <bool kFade>
MOTES_INLINE void sort_among(const image::TilePlanes& tile, const image::Splat& s, const unsigned char* records,
                             std::size_t count, Among& some) {
  read_places(s.record_bytes, s.form.depth, records, count, some.position, some.depth);
  some.opens = some.testeds = 0;
  for (std::size_t i = 0; i < count; i += kLanes) find_among<kFade>(tile, s, i, count, some);
}

MOTES_INLINE auto centers_among(const image::Settling& s, const Among& some) {
  return [&](Ints number) {
    return fixed_centers(s, (Uints)gathered(some.position, number), (Uints)gathered(some.depth, number));
  };
}

// Finds the records that are close to a surface. Open ones are in front of all surfaces.
MOTES_OUTLINE std::size_t find_close(const image::Settling& s, Among& some) {
  return find_close(s, some.tested, some.testeds, centers_among(s, some), some.close);
}

// Makes records deeper that are close behind a surface.
MOTES_OUTLINE void settle(const image::Settling& s, Among& some, std::size_t close) {
  std::uint32_t deeper[Among::kMost], depths[Among::kMost];
  const std::size_t found = settle(s, some.close, close, centers_among(s, some), deeper, depths);
  for (std::size_t k = 0; k < found; ++k) some.depth[deeper[k]] = depths[k];
}

// Adds spheres that nothing hides.
template <int kVectors, bool kSaturating>
void add_balls(const image::TilePlanes& planes, const image::Splat& task, const unsigned char* records,
               std::size_t count) {
  const image::Splat s = task;
  const image::TilePlanes tile = planes;
  const Channels channel = channels();
  RecordLight light = light_of(channel, s.color);
  const auto bytes = static_cast<std::size_t>(s.record_bytes);
  Among some;
  while (count != 0) {
    const std::size_t number = count < Among::kMost ? count : Among::kMost;
    read_places(s.record_bytes, s.form.depth, records, number, some.position, some.depth);
    some.opens = 0;
    for (std::size_t i = 0; i < number; i += kLanes) {
      const FootprintPositions at = places(s, load_uints(some.position + i));
      const Mask inside = touch(at, s.size) & first_lanes(number - i);
      store_mask(some.light + i, in_light(at));
      store_mask(some.weights + i, light_weights(s, at, inside));
      some.opens += squeeze(some.open + some.opens, lane_numbers() + static_cast<std::uint32_t>(i), inside);
    }
    const std::uint8_t* const table = light_table(s);
    for (std::size_t k = 0; k < some.opens; ++k) {
      const std::size_t i = some.open[k];
      if (s.form.color != 0) light = light_of(channel, color_of(s, records + i * bytes));
      add_open<kVectors, kSaturating>(s, light, table + some.weights[i], tile.light + some.light[i]);
    }
    records += number * bytes;
    count -= number;
  }
}

// Adds record `i`, testing its depth at each pixel.
template <int kVectors, bool kSaturating, bool kFade>
MOTES_INLINE void add_tested(const image::TilePlanes& tile, const image::Splat& s, const Spread& spreading,
                             const RecordLight& light, const Among& some, std::size_t i) {
  const std::uint32_t depth = some.depth[i];
  const std::uint8_t* weights = light_table(s) + some.weights[i];
  std::uint32_t* to = tile.light + some.light[i];
  const std::uint32_t* wall = tile.depth + some.pixel[i];
  for (int row = 0; row < s.size; ++row, weights += s.row_bytes) {
    for (int j = 0; j < kVectors; ++j) {
      const Uints here = load_spread(spreading, wall, j);
      Uints more = multiply_short(load_bytes(weights + j * kWidth), light.part[j % 3]);
      if (kFade) more = more * faded(here, depth, s.fade) >> 12;
      add<kSaturating>(to + j * kWidth, where_seen(more, here, all_uints(depth)));
    }
    to += image::kLightStride;
    wall += image::kPixelStride;
  }
}

template <int kVectors, bool kSaturating, bool kFade>
void add_among(const image::TilePlanes& planes, const image::Splat& task, const unsigned char* records,
               std::size_t count) {
  const image::Splat s = task;
  const image::TilePlanes tile = planes;
  const Channels channel = channels();
  const Spread spreading = spread();
  const RecordLight of_all = light_of(channel, s.color);
  const auto bytes = static_cast<std::size_t>(s.record_bytes);
  const auto light = [&](std::size_t i) {
    return s.form.color != 0 ? light_of(channel, color_of(s, records + i * bytes)) : of_all;
  };
  Among some;
  while (count != 0) {
    const std::size_t number = count < Among::kMost ? count : Among::kMost;
    sort_among<kFade>(tile, s, records, number, some);
    const std::size_t close = s.settling == nullptr ? 0 : find_close(*s.settling, some);
    const std::uint8_t* const table = light_table(s);
    for (std::size_t k = 0; k < some.opens; ++k) {
      const std::size_t i = some.open[k];
      add_open<kVectors, kSaturating>(s, light(i), table + some.weights[i], tile.light + some.light[i]);
    }
    if (close != 0) settle(*s.settling, some, close);  // what it reads has arrived meanwhile
    for (std::size_t k = 0; k < some.testeds; ++k) {
      const std::size_t i = some.tested[k];
      add_tested<kVectors, kSaturating, kFade>(tile, s, spreading, light(i), some, i);
    }
    records += number * bytes;
    count -= number;
  }
}

}  // namespace motes::MOTES_ISA
