// Draws opaque records of one fixed size: at each pixel the nearest wins. Records that are behind everything in their
// footprint are skipped; in a crowd those are the majority.
#pragma once

#include "image/raster/depth_blocks.h"
#include "image/raster/pixel_lanes.h"
#include "image/raster/point_lanes.h"
#include "image/raster/splat_lanes.h"
#include "simd/squeeze.h"

namespace motes::MOTES_ISA {

// Up to kMost records: their positions, and the list of those that may be seen.
struct Candidates {
  static constexpr std::size_t kMost = 128;

  alignas(64) std::uint32_t position[kMost], depth[kMost];
  alignas(64) std::int32_t pixel[kMost], row[kMost];  // offset from the tile's first pixel, and first row in tables
  alignas(64) std::uint32_t seen[kMost + kLanes];  // indices of records
};

// Lists the records that may be visible and returns how many. It has no branches, because whether a record is visible
// does not predict the next one.
MOTES_INLINE std::size_t find_seen(const image::TilePlanes& tile, const image::Splat& s, const unsigned char* records,
                                   std::size_t count, Candidates& crowd) {
  read_places(s.record_bytes, s.form.depth, records, count, crowd.position, crowd.depth);
  const float radius = s.bulge != nullptr ? s.radius : 0;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < count; i += kLanes) {
    const FootprintPositions at = places(s, load_uints(crowd.position + i));
    Mask chosen = touch(at, s.size) & first_lanes(count - i);
    if (tile.blocks != nullptr) {
      const Ints block = image::DepthBlocks::at(at.column, at.row) & chosen;
      const Floats center = (Floats)load_uints(crowd.depth + i);
      chosen &= center - center * radius <= gather(tile.blocks + 1, block + block);
    }
    store_mask(crowd.pixel + i, at.row * image::kPixelStride + at.column);
    store_mask(crowd.row + i, at.phase * s.size);
    seen += squeeze(crowd.seen + seen, lane_numbers() + static_cast<std::uint32_t>(i), chosen);
  }
  return seen;
}

// Colour and depth of a record.
struct Coat {
  std::uint32_t color, depth;
};

// Calls draw(coat, pixel, row) for each record that may be seen; pixel and row as in Crowd.
template <class Draw>
MOTES_INLINE void for_each_seen(const image::TilePlanes& planes, const image::Splat& s, const unsigned char* records,
                                std::size_t count, const Draw& draw) {
  const auto bytes = static_cast<std::size_t>(s.record_bytes);
  Candidates crowd;
  while (count != 0) {
    const std::size_t number = count < Candidates::kMost ? count : Candidates::kMost;
    const std::size_t seen = find_seen(planes, s, records, number, crowd);
    for (std::size_t k = 0; k < seen; ++k) {
      const std::size_t i = crowd.seen[k];
      draw(Coat{color_of(s, records + i * bytes), crowd.depth[i]}, crowd.pixel[i], crowd.row[i]);
    }
    records += number * bytes;
    count -= number;
  }
}

// Draws a flat record whose rows have kVectors vectors of kLongs pixels.
template <int kVectors>
MOTES_INLINE void draw_flat(const image::Splat& s, const Coat& coat, const std::uint16_t* covered,
                            image::NearestSurface* to) {
  const Longs here = all_longs(image::NearestSurface{coat.depth} << 32 | 0xff000000u | coat.color);
  for (int row = 0; row < s.size; ++row, to += image::kPixelStride) {
    for (int j = 0; j < kVectors; ++j) keep_nearest(to + j * kLongs, here, covered[row] >> (j * kLongs));
  }
}

template <int kVectors>
void flat_records(const image::TilePlanes& planes, const image::Splat& task, const unsigned char* records,
                  std::size_t count) {
  const image::Splat s = task;
  image::NearestSurface* const surfaces = planes.surfaces;
  for_each_seen(planes, s, records, count, [&](const Coat& coat, std::ptrdiff_t pixel, std::ptrdiff_t row) {
    draw_flat<kVectors>(s, coat, s.covered + row, surfaces + pixel);
  });
}

// Returns colours times tints, of which each channel is a fraction of 255.
MOTES_INLINE Uints tinted(Uints color, Uints tint) {
  Uints all{};
  for (const int shift : {0, 8, 16}) {
    const Uints product = multiply_short(color >> shift & 0xffu, tint >> shift & 0xffu) + 128u;
    all |= (product + (product >> 8)) >> 8 << shift;
  }
  return all;
}

#if MOTES_WIDTH == 512
// Draws eight pixels of a sphere's row with half vectors, of which the processor executes more in parallel.
MOTES_INLINE void round_eight(image::NearestSurface* to, const std::uint32_t* shade, const float* bulge, Uints color,
                              Floats center, Floats radius, unsigned covered) {
  const __m256i shades = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(shade));
  const __m256i surface = _mm256_or_si256(_mm512_castsi512_si256((__m512i)color), shades);
  const __m256 nearer = _mm256_mul_ps(_mm512_castps512_ps256((__m512)radius), _mm256_loadu_ps(bulge));
  const __m256 depth =
      _mm256_max_ps(_mm256_sub_ps(_mm512_castps512_ps256((__m512)center), nearer), _mm256_set1_ps(kLeastDepth));
  keep_nearest(to, nearest_of((Uints)_mm512_castps256_ps512(depth), (Uints)_mm512_castsi256_si512(surface), 0),
               covered);
}
#endif

// Draws a sphere whose rows have kVectors vectors of kWidth pixels; kHalf: the last one is half a vector. `in_tables`:
// its first row in the tables.
template <int kVectors, bool kHalf, bool kTinted>
MOTES_INLINE void draw_round(const image::Splat& s, const Coat& coat, std::ptrdiff_t in_tables,
                             image::NearestSurface* to) {
  constexpr int kInRow = image::surface_row(kHalf ? kVectors * kWidth - kLongs : kVectors * kWidth);
  const Uints color = all_uints(coat.color & 0xffffffu);
  const Floats center = (Floats)all_uints(coat.depth);
  const Floats radius = center * all(s.radius);
  const std::uint16_t* covered = s.covered + in_tables;
  const std::uint32_t* shade = s.shade + in_tables * kInRow;
  const float* bulge = s.bulge + in_tables * kInRow;
  const std::uint32_t* tint = s.tint + (kTinted ? in_tables * kInRow : 0);
  const auto color_at = [&](int first) { return kTinted ? tinted(color, load_uints(tint + first)) : color; };
  for (int row = 0; row < s.size; ++row, to += image::kPixelStride, shade += kInRow, bulge += kInRow) {
#if MOTES_WIDTH == 512
    if (kHalf && kVectors == 1) {
      round_eight(to, shade, bulge, color_at(0), center, radius, covered[row]);
      tint += kTinted ? kInRow : 0;
      continue;
    }
#endif
    for (int j = 0; j < kVectors; ++j) {
      const Uints surface = color_at(j * kWidth) | load_uints(shade + j * kWidth);
      const Uints depth = (Uints)max(center - radius * load(bulge + j * kWidth), all(kLeastDepth));
      const unsigned bits = static_cast<unsigned>(covered[row]) >> (j * kWidth);
      keep_nearest(to + j * kWidth, nearest_of(depth, surface, 0), bits);
      if (!kHalf || j + 1 < kVectors) {
        keep_nearest(to + j * kWidth + kLongs, nearest_of(depth, surface, 1), bits >> kLongs);
      }
    }
    tint += kTinted ? kInRow : 0;
  }
}

template <int kVectors, bool kHalf, bool kTinted>
void round_records(const image::TilePlanes& planes, const image::Splat& task, const unsigned char* records,
                   std::size_t count) {
  const image::Splat s = task;
  image::NearestSurface* const surfaces = planes.surfaces;
  for_each_seen(planes, s, records, count, [&](const Coat& coat, std::ptrdiff_t pixel, std::ptrdiff_t row) {
    draw_round<kVectors, kHalf, kTinted>(s, coat, row, surfaces + pixel);
  });
}

template <int kVectors>
void flat_from(const image::TilePlanes& tile, const image::Splat& s, const unsigned char* records, std::size_t count) {
  if constexpr (kVectors * kLongs < image::kMaxFootprint) {
    if (kVectors * kLongs < s.size) return flat_from<kVectors + 1>(tile, s, records, count);
  }
  flat_records<kVectors>(tile, s, records, count);
}

template <int kVectors, bool kTinted>
void round_from(const image::TilePlanes& tile, const image::Splat& s, const unsigned char* records, std::size_t count) {
  if constexpr (kVectors * kWidth < image::kMaxFootprint) {
    if (kVectors * kWidth < s.size) return round_from<kVectors + 1, kTinted>(tile, s, records, count);
  }
  if (s.size <= kVectors * kWidth - kLongs) return round_records<kVectors, true, kTinted>(tile, s, records, count);
  round_records<kVectors, false, kTinted>(tile, s, records, count);
}

inline void opaque_any(const image::TilePlanes& tile, const image::Splat& s, const unsigned char* records,
                       std::size_t count) {
  if (s.bulge == nullptr) return flat_from<1>(tile, s, records, count);
  s.tint == nullptr ? round_from<1, false>(tile, s, records, count) : round_from<1, true>(tile, s, records, count);
}

MOTES_INLINE Longs greater(Longs a, Longs b) { return a > b ? a : b; }

// Implements SplatLanes::measure_surfaces.
inline void measure_surfaces(const image::TilePlanes& tile, int rows, int columns, std::uint32_t* farthest) {
  constexpr int kBlock = 1 << image::DepthBlocks::kBits, kVectors = kBlock / kLongs;
  for (int top = 0; top < image::kTile; top += kBlock) {
    const int bottom = top + kBlock < rows ? top + kBlock : rows;
    for (int left = 0; left < image::kTile; left += kBlock) {
      Longs most[kVectors] = {};
      for (int row = top; row < bottom; ++row) {
        const image::NearestSurface* from =
            tile.surfaces + static_cast<std::ptrdiff_t>(row) * image::kPixelStride + left;
        for (int j = 0; j < kVectors; ++j) most[j] = greater(most[j], load_longs(from + j * kLongs));
      }
      const int inside = columns - left < kBlock ? columns - left : kBlock;
      std::int64_t greatest = 1;
      for (int i = 0; i < inside; ++i) {
        const std::int64_t here = most[i / kLongs][i % kLongs];
        greatest = here > greatest ? here : greatest;
      }
      *farthest++ = static_cast<std::uint32_t>((greatest - 1) >> 32);  // no_surface(depth) yields depth
    }
  }
}

}  // namespace motes::MOTES_ISA
