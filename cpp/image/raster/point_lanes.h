// Draws points that nothing hides. Computing a point's position costs more than drawing it, so positions are computed
// for a vector of points at once.
#pragma once

#include "image/layout.h"
#include "image/raster/pixel_lanes.h"
#include "image/raster/splat_lanes.h"

namespace motes::MOTES_ISA {

// Side of a point's footprint, px; bytes and vectors per row of its weights.
inline constexpr int kPointSize = 2, kPointRow = 16;
inline constexpr int kPointVectors = (3 * kPointSize + kWidth - 1) / kWidth;
template <bool kColored>
inline constexpr std::size_t kPointBytes = image::record_bytes(image::Layout::plain, kColored);

#if MOTES_WIDTH == 512
// Adds a point, two pixels wide, with half vectors, which rarely cross a cache line.
template <bool kSaturating>
MOTES_INLINE void add_point(const RecordLight& light, const std::uint8_t* weights, std::uint32_t* to) {
  const __m256i color = _mm512_castsi512_si256((__m512i)light.part[0]);
  for (int row = 0; row < kPointSize; ++row, to += image::kLightStride, weights += kPointRow) {
    const __m256i weight = _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(weights)));
    const __m256i before = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(to));
    __m256i sum = _mm256_add_epi32(before, _mm256_madd_epi16(weight, color));
    if (kSaturating) sum = _mm256_mask_set1_epi32(sum, _mm256_cmplt_epu32_mask(sum, before), -1);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), sum);
  }
}
#else
template <bool kSaturating>
MOTES_INLINE void add_point(const RecordLight& light, const std::uint8_t* weights, std::uint32_t* to) {
  add_rows<kPointVectors, kSaturating>(kPointSize, kPointRow, light, weights, to);
}
#endif

// First pixels of footprints in the tile, and their phases (sub-pixel positions, which select a footprint of the
// table).
struct FootprintPositions {
  Ints column, row, phase;
};
MOTES_INLINE FootprintPositions places(const image::Splat& s, Uints positions) {
  const Ints x = ((Ints)(positions << 16) >> 16) - s.origin_x, y = ((Ints)positions >> 16) - s.origin_y;
  const int up = 4 - s.sub_bits, down = 4 - s.phase_bits;
  const Ints phase_x = ((Ints)((Uints)x << up) & 15) >> down, phase_y = ((Ints)((Uints)y << up) & 15) >> down;
  return {x >> s.sub_bits, y >> s.sub_bits, (Ints)((Uints)phase_y << s.phase_bits) | phase_x};
}
// Returns which footprints have a pixel in the tile.
MOTES_INLINE Mask touch(const FootprintPositions& at, int size) {
  return (min_ints(at.column, at.row) > -size) & (max_ints(at.column, at.row) < image::kTile);
}
MOTES_INLINE Ints in_light(const FootprintPositions& at) { return at.row * image::kLightStride + 3 * at.column; }

// Returns the colour of a record: its own, or the common one.
MOTES_INLINE std::uint32_t color_of(const image::Splat& s, const unsigned char* record) {
  return s.form.color != 0 ? word_at(record + s.form.color) : s.color;
}

// Reads positions and depths of records; a depth is `depth_at` bytes from the start of its record. `positions` and
// `depths` have room for whole vectors.
MOTES_INLINE void read_places(int record_bytes, int depth_at, const unsigned char* records, std::size_t count,
                              std::uint32_t* positions, std::uint32_t* depths) {
  std::size_t i = 0;
  if (record_bytes == 8) {
    for (; i + kLanes <= count; i += kLanes) {
      Uints position, depth;
      split(records + i * 8, position, depth);
      store_uints(positions + i, position);
      store_uints(depths + i, depth);
    }
  }
#if MOTES_WIDTH == 512
  if (record_bytes == 12 && depth_at == 8) {
    for (; i + kLanes <= count; i += kLanes) {
      Uints position, depth;
      split_thirds(records + i * 12, position, depth);
      store_uints(positions + i, position);
      store_uints(depths + i, depth);
    }
  }
#endif
  for (const auto bytes = static_cast<std::size_t>(record_bytes); i < count; ++i) {
    positions[i] = word_at(records + i * bytes);
    depths[i] = word_at(records + i * bytes + depth_at);
  }
  for (; i % kLanes != 0; ++i) positions[i] = depths[i] = 0;
}

// Words of kWidth records of points; `color` is undefined where records carry none.
struct Points {
  Uints position, color;
};

template <bool kColored>
MOTES_INLINE Points whole_points(const unsigned char* from) {
  Points p{};
  if (kColored) {
    split(from, p.position, p.color);
  } else {
    __builtin_memcpy(&p.position, from, sizeof p.position);
  }
  return p;
}

// Reads fewer records than a vector has lanes; the other lanes are undefined.
template <bool kColored>
MOTES_INLINE Points some_points(const unsigned char* from, int number) {
  constexpr std::size_t kBytes = kPointBytes<kColored>;
#if MOTES_WIDTH == 512
  Points p{};
  const std::uint32_t words = (1u << static_cast<int>(kBytes / 4) * number) - 1;
  const __m512i low = _mm512_maskz_loadu_epi32(static_cast<__mmask16>(words), from);
  if (kColored) {
    const __m512i high = _mm512_maskz_loadu_epi32(static_cast<__mmask16>(words >> 16), from + kLongs * kBytes);
    split(low, high, p.position, p.color);
  } else {
    p.position = (Uints)low;
  }
  return p;
#else
  alignas(64) unsigned char padded[kLanes * kBytes] = {};
  for (int k = 0; k < number; ++k) __builtin_memcpy(padded + k * kBytes, from + k * kBytes, kBytes);
  return whole_points<kColored>(padded);
#endif
}

// Draws the first `number` points of a vector; draws nothing and returns false if some do not belong to this tile.
template <bool kSaturating, bool kColored>
MOTES_INLINE bool add_vector(const image::TilePlanes& planes, const image::Splat& s, const Channels& channel,
                             const Points& p, const unsigned char* records, int number) {
  const FootprintPositions at = places(s, p.position);
  if (any(~touch(at, kPointSize) & first_lanes(static_cast<std::size_t>(number)))) return false;
  alignas(64) std::int32_t first[kWidth], phase[kWidth];
  store_mask(first, in_light(at));
  store_mask(phase, at.phase);
  const std::uint32_t color = kColored ? word_at(records + 4) : s.color;
  const bool alike = !kColored || !any((Mask)(p.color != color) & first_lanes(static_cast<std::size_t>(number)));
  RecordLight light = light_of(channel, color);
  for (int k = 0; k < number; ++k) {
    if (!alike) light = light_of(channel, word_at(records + static_cast<std::size_t>(k) * kPointBytes<kColored> + 4));
    add_point<kSaturating>(light, s.weights + phase[k] * (kPointSize * kPointRow), planes.light + first[k]);
  }
  return true;
}

}  // namespace motes::MOTES_ISA
