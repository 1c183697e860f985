// Draws opaque records of one fixed size: at each pixel the nearest wins. Records that are behind everything in their
// footprint are skipped; in a crowd those are the majority.
#pragma once

#include "image/balls/ball_lanes.h"
#include "image/raster/depth_blocks.h"
#include "image/raster/pixel_lanes.h"
#include "image/raster/point_lanes.h"
#include "image/raster/splat_lanes.h"
#include "simd/elementary.h"
#include "simd/squeeze.h"

namespace motes::MOTES_ISA {

// Up to kMost records: their positions, and the list of those that may be seen.
struct Candidates {
  static constexpr std::size_t kMost = 128;

  alignas(64) std::uint32_t position[kMost], depth[kMost];
  alignas(64) std::int32_t pixel[kMost], row[kMost];  // offset from the tile's first pixel, and first row in tables
  alignas(64) std::int32_t ball[kMost];           // of spheres: where their unit begins
  alignas(64) float clear[kMost];                 // the part of their light that passes the fog, if there is any
  alignas(64) std::uint32_t seen[kMost + kLanes];  // indices of records
};

// Returns the part of the light of spheres that passes the fog: of the visible side, whose mean depth is 2/3 of the
// radius less than that of the middle.
MOTES_INLINE Floats clear_of(const image::Splat& s, Uints position, Floats depth) {
  const Floats x = to_floats((Ints)(position << 16) >> 16) * s.per_unit;
  const Floats y = to_floats((Ints)position >> 16) * s.per_unit;
  const Floats away = depth * (sqrt(x * x + y * y + 1.0f) - s.radius * (2.0f / 3));
  return exp(-min(max(away * s.fog_density, Floats{}), all(80.0f)));
}

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
    if (s.fog_density > 0)
      store(crowd.clear + i, clear_of(s, load_uints(crowd.position + i), (Floats)load_uints(crowd.depth + i)));
    if (tile.blocks != nullptr) {
      const Ints block = image::DepthBlocks::at(at.column, at.row) & chosen;
      const Floats center = (Floats)load_uints(crowd.depth + i);
      chosen &= center - center * radius <= gather(tile.blocks + 1, block + block);
    }
    store_mask(crowd.pixel + i, at.row * image::kPixelStride + at.column);
    store_mask(crowd.row + i, at.phase * s.size);
    if (s.balls != nullptr) {
      store_mask(crowd.ball + i, balls_at(*s.balls, ball_units(*s.balls->look, at.column, at.row, at.phase), chosen));
    }
    seen += squeeze(crowd.seen + seen, lane_numbers() + static_cast<std::uint32_t>(i), chosen);
  }
  return seen;
}

// Colour and depth of a record, and the part of its light that passes the fog.
struct Coat {
  std::uint32_t color, depth;
  float clear;
};

// Calls draw(coat, pixel, row, ball) for each record that may be seen; see Candidates.
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
      draw(Coat{color_of(s, records + i * bytes), crowd.depth[i], s.fog_density > 0 ? crowd.clear[i] : 1},
           crowd.pixel[i], crowd.row[i], s.bulge != nullptr ? crowd.ball[i] : 0);
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
  for_each_seen(planes, s, records, count, [&](const Coat& coat, std::ptrdiff_t pixel, std::ptrdiff_t row, int) {
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

// How pixels of a sphere get their colours: the record's with a shade, the same times the colour of a white sphere's
// surface, or behind fog.
enum class Coating { plain, tinted, fogged };

// What is left of a record's light behind fog, per shade and colour, and the light of the fog.
struct Veil {
  Floats3 own, fog;

  MOTES_INLINE Veil(const image::Splat& s, const Coat& coat) : fog(all3(s.fog) * (1.0f - coat.clear)) {
    const float part = coat.clear * (1.0f / (255 * 255 * 255));
    const auto channel = [&](int shift) { return all(static_cast<float>(coat.color >> shift & 0xffu) * part); };
    own = {channel(0), channel(8), channel(16)};
  }

  // Returns surfaces of these, which are those of a white sphere.
  MOTES_INLINE Uints surfaces(Uints white) const {
    const Floats bright = to_floats((Ints)(white >> image::kShadeShift));
    const auto channel = [&](int shift) { return to_floats((Ints)(white >> shift & 0xffu)) * bright; };
    return surface_of({own.x * channel(0) + fog.x, own.y * channel(8) + fog.y, own.z * channel(16) + fog.z});
  }
};

#if MOTES_WIDTH == 512
// Draws eight pixels of a sphere's row with half vectors, of which the processor executes more in parallel.
MOTES_INLINE void round_eight(image::NearestSurface* to, __m256i surface, const float* bulge, Floats center,
                              Floats radius, unsigned covered) {
  const __m256 nearer = _mm256_mul_ps(_mm512_castps512_ps256((__m512)radius), _mm256_loadu_ps(bulge));
  const __m256 depth =
      _mm256_max_ps(_mm256_sub_ps(_mm512_castps512_ps256((__m512)center), nearer), _mm256_set1_ps(kLeastDepth));
  keep_nearest(to, nearest_of((Uints)_mm512_castps256_ps512(depth), (Uints)_mm512_castsi256_si512(surface), 0),
               covered);
}
#endif

// Draws a sphere whose rows have kVectors vectors of kWidth pixels; kHalf: the last one is half a vector. `in_tables`:
// its first row in the tables; `ball`: its unit.
template <int kVectors, bool kHalf, Coating kCoating>
MOTES_INLINE void draw_round(const image::Splat& s, const Coat& coat, std::ptrdiff_t in_tables,
                             const unsigned char* ball, image::NearestSurface* to) {
  constexpr int kInRow = image::surface_row(kHalf ? kVectors * kWidth - kLongs : kVectors * kWidth);
  constexpr bool kTints = kCoating != Coating::plain;
  const Uints color = all_uints(coat.color & 0xffffffu);
  const Veil veil(s, coat);
  const Floats center = (Floats)all_uints(coat.depth);
  const Floats radius = center * all(s.radius);
  const std::uint16_t* covered = s.covered + in_tables;
  const float* bulge = s.bulge + in_tables * kInRow;
  const auto surface_at = [&](int first) __attribute__((always_inline)) {
    if constexpr (!kTints) return color | load_bytes(ball + first) << image::kShadeShift;
    Uints white;
    __builtin_memcpy(&white, ball + std::ptrdiff_t{4} * first, sizeof white);
    if constexpr (kCoating == Coating::fogged) return veil.surfaces(white);
    return tinted(color, white) | (white & 0xff000000u);
  };
  constexpr std::ptrdiff_t kRowBytes = kTints ? 4 * kInRow : kInRow;
  for (int row = 0; row < s.size; ++row, to += image::kPixelStride, ball += kRowBytes, bulge += kInRow) {
#if MOTES_WIDTH == 512
    if (kHalf && kVectors == 1) {
      auto surface = _mm512_castsi512_si256((__m512i)(kTints ? surface_at(0) : color));
      if (!kTints) {
        const __m256i shades = _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(ball)));
        surface = _mm256_or_si256(surface, _mm256_slli_epi32(shades, image::kShadeShift));
      }
      round_eight(to, surface, bulge, center, radius, covered[row]);
      continue;
    }
#endif
    for (int j = 0; j < kVectors; ++j) {
      const Uints surface = surface_at(j * kWidth);
      const Uints depth = (Uints)max(center - radius * load(bulge + j * kWidth), all(kLeastDepth));
      const unsigned bits = static_cast<unsigned>(covered[row]) >> (j * kWidth);
      keep_nearest(to + j * kWidth, nearest_of(depth, surface, 0), bits);
      if (!kHalf || j + 1 < kVectors) {
        keep_nearest(to + j * kWidth + kLongs, nearest_of(depth, surface, 1), bits >> kLongs);
      }
    }
  }
}

template <int kVectors, bool kHalf, Coating kCoating>
void round_records(const image::TilePlanes& planes, const image::Splat& task, const unsigned char* records,
                   std::size_t count) {
  const image::Splat s = task;
  image::NearestSurface* const surfaces = planes.surfaces;
  for_each_seen(planes, s, records, count, [&](const Coat& coat, std::ptrdiff_t pixel, std::ptrdiff_t row, int ball) {
    draw_round<kVectors, kHalf, kCoating>(s, coat, row, s.balls->bytes + ball, surfaces + pixel);
  });
}

template <int kVectors>
void flat_from(const image::TilePlanes& tile, const image::Splat& s, const unsigned char* records, std::size_t count) {
  if constexpr (kVectors * kLongs < image::kMaxFootprint) {
    if (kVectors * kLongs < s.size) return flat_from<kVectors + 1>(tile, s, records, count);
  }
  flat_records<kVectors>(tile, s, records, count);
}

template <int kVectors, Coating kCoating>
void round_from(const image::TilePlanes& tile, const image::Splat& s, const unsigned char* records, std::size_t count) {
  if constexpr (kVectors * kWidth < image::kMaxFootprint) {
    if (kVectors * kWidth < s.size) return round_from<kVectors + 1, kCoating>(tile, s, records, count);
  }
  if (s.size <= kVectors * kWidth - kLongs) return round_records<kVectors, true, kCoating>(tile, s, records, count);
  round_records<kVectors, false, kCoating>(tile, s, records, count);
}

inline void opaque_any(const image::TilePlanes& tile, const image::Splat& s, const unsigned char* records,
                       std::size_t count) {
  if (s.bulge == nullptr) return flat_from<1>(tile, s, records, count);
  if (s.balls->look->form == image::BallForm::shades) return round_from<1, Coating::plain>(tile, s, records, count);
  if (s.fog_density > 0) return round_from<1, Coating::fogged>(tile, s, records, count);
  round_from<1, Coating::tinted>(tile, s, records, count);
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
