// Compiled once for each instruction set: see simd/simd.h for the rules. Integers only: sums do not depend on order.
#include "image/splat_lanes.h"

#include "image/grid.h"
#include "simd/simd.h"

namespace motes::MOTES_ISA {
namespace {

using image::Splat;
using image::TileSums;

constexpr int kWidth = static_cast<int>(kLanes);

MOTES_INLINE Uints load_uints(const std::uint32_t* from) {
  Uints v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
MOTES_INLINE void store_uints(std::uint32_t* to, Uints v) { __builtin_memcpy(to, &v, sizeof v); }

// The products of lanes that are below 2^15.
MOTES_INLINE Uints multiply_short(Uints a, Uints b) {
#if MOTES_WIDTH == 512
  return (Uints)_mm512_madd_epi16((__m512i)a, (__m512i)b);
#elif MOTES_WIDTH == 256
  return (Uints)_mm256_madd_epi16((__m256i)a, (__m256i)b);
#elif MOTES_WIDTH == 128
  return (Uints)_mm_madd_epi16((__m128i)a, (__m128i)b);
#else
  return a * b;
#endif
}

// Puts one byte into each lane.
MOTES_INLINE Uints load_bytes(const std::uint8_t* from) {
#if MOTES_WIDTH == 512
  // The masked form: g++ 12 warns of an uninitialised operand in the plain one.
  return (Uints)_mm512_maskz_cvtepu8_epi32(0xffff, _mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
#elif MOTES_WIDTH == 256
  return (Uints)_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(from)));
#elif MOTES_WIDTH == 128
  std::int32_t four;
  __builtin_memcpy(&four, from, sizeof four);
  const __m128i bytes = _mm_cvtsi32_si128(four);
  return (Uints)_mm_unpacklo_epi16(_mm_unpacklo_epi8(bytes, _mm_setzero_si128()), _mm_setzero_si128());
#else
  Uints v;
  for (int lane = 0; lane < kWidth; ++lane) v[lane] = from[lane];
  return v;
#endif
}

// A record's light as three vectors that repeat red, green, blue: 12 bits per colour, colour * alpha / 16.
struct Light {
  Uints part[3];
};

#if MOTES_WIDTH == 512 || MOTES_WIDTH == 256
// Shuffle controls: lane l of vector j takes byte (l + kWidth * j) % 3 and zeros.
struct Channels {
  Uints part[3];
};
MOTES_INLINE Channels channels() {
  Channels c;
  for (int j = 0; j < 3; ++j) {
    for (int lane = 0; lane < kWidth; ++lane) {
      c.part[j][lane] = 0x80808000u | static_cast<std::uint32_t>((lane + kWidth * j) % 3);
    }
  }
  return c;
}
MOTES_INLINE Light light_of(const Channels& channels, std::uint32_t color) {
  const Uints word = all_uints(color);
  const Uints alpha = word >> 24;
  Light light;
  for (int j = 0; j < 3; ++j) {
#if MOTES_WIDTH == 512
    const Uints bytes = (Uints)_mm512_shuffle_epi8((__m512i)word, (__m512i)channels.part[j]);
#else
    const Uints bytes = (Uints)_mm256_shuffle_epi8((__m256i)word, (__m256i)channels.part[j]);
#endif
    light.part[j] = (multiply_short(bytes, alpha) + 8u) >> 4;
  }
  return light;
}
#else
struct Channels {};
MOTES_INLINE Channels channels() { return {}; }
MOTES_INLINE Light light_of(const Channels&, std::uint32_t color) {
  const std::uint32_t alpha = color >> 24;
  const std::uint32_t r = ((color & 0xffu) * alpha + 8) >> 4;
  const std::uint32_t g = ((color >> 8 & 0xffu) * alpha + 8) >> 4;
  const std::uint32_t b = ((color >> 16 & 0xffu) * alpha + 8) >> 4;
  static_assert(kLanes == 4 || MOTES_WIDTH != 0);
  return {{Uints{r, g, b, r}, Uints{g, b, r, g}, Uints{b, r, g, b}}};
}
#endif

template <bool kSaturating>
MOTES_INLINE void add(std::uint32_t* to, Uints more) {
  const Uints before = load_uints(to);
  Uints sum = before + more;
  if (kSaturating) sum |= (Uints)(sum < before);
  store_uints(to, sum);
}

MOTES_INLINE std::uint32_t word_at(const unsigned char* from) {
  std::uint32_t word;
  __builtin_memcpy(&word, from, sizeof word);
  return word;
}

// Where a footprint starts in the tile, and its weights; false where the record does not belong to this tile.
MOTES_INLINE bool place(const Splat& s, int stride, std::uint32_t position, std::ptrdiff_t& at,
                        const std::uint8_t*& weights) {
  const int x = static_cast<std::int16_t>(position & 0xffffu) - s.origin_x;
  const int y = static_cast<std::int16_t>(position >> 16) - s.origin_y;
  const int column = x >> s.sub_bits;
  const int row = y >> s.sub_bits;
  const unsigned reach = static_cast<unsigned>(s.size + image::kTile - 1);
  if (static_cast<unsigned>(column + s.size - 1) >= reach || static_cast<unsigned>(row + s.size - 1) >= reach) {
    return false;
  }
  at = static_cast<std::ptrdiff_t>(row) * stride + 3 * column;
  const int up = 4 - s.sub_bits;
  const int down = 4 - s.phase_bits;
  const int phase_x = (x << up & 15) >> down;
  const int phase_y = (y << up & 15) >> down;
  weights = s.weights + static_cast<std::ptrdiff_t>((phase_y << s.phase_bits | phase_x) * s.size) * s.row_bytes;
  return true;
}

template <int kVectors, bool kSaturating, bool kDepth>
void splat(const TileSums& sums, const Splat& task, const unsigned char* records, std::size_t count) {
  const Splat s = task;
  const TileSums tile = sums;
  const Channels channel = channels();
  const std::size_t record_bytes = s.with_depth ? 12 : 8;
  for (const unsigned char* r = records; r != records + count * record_bytes; r += record_bytes) {
    std::ptrdiff_t at;
    const std::uint8_t* weights;
    if (!place(s, tile.stride, word_at(r), at, weights)) continue;
    const std::uint32_t depth = kDepth ? word_at(r + 8) : 0;
    if (kDepth && depth > tile.farthest) continue;
    const Light light = light_of(channel, word_at(r + 4));
    std::uint32_t* to = tile.light + at;
    if (kDepth && depth > tile.nearest) {
      const std::uint32_t* wall = tile.depth + at;
      for (int row = 0; row < s.size; ++row, to += tile.stride, wall += tile.stride, weights += s.row_bytes) {
        for (int j = 0; j < kVectors; ++j) {
          const Uints more = multiply_short(load_bytes(weights + j * kWidth), light.part[j % 3]);
          const Uints before_wall = (Uints)(load_uints(wall + j * kWidth) >= all_uints(depth));
          add<kSaturating>(to + j * kWidth, more & before_wall);
        }
      }
      continue;
    }
    for (int row = 0; row < s.size; ++row, to += tile.stride, weights += s.row_bytes) {
      for (int j = 0; j < kVectors; ++j) {
        add<kSaturating>(to + j * kWidth, multiply_short(load_bytes(weights + j * kWidth), light.part[j % 3]));
      }
    }
  }
}

template <int kVectors>
MOTES_INLINE void splat_rows(const TileSums& sums, const Splat& s, const unsigned char* records, std::size_t count) {
  const bool depth = s.with_depth && sums.depth != nullptr;
  if (s.saturating) {
    depth ? splat<kVectors, true, true>(sums, s, records, count)
          : splat<kVectors, true, false>(sums, s, records, count);
  } else {
    depth ? splat<kVectors, false, true>(sums, s, records, count)
          : splat<kVectors, false, false>(sums, s, records, count);
  }
}

// The number of vectors per row is a constant of each build's loop.
template <int kVectors>
void splat_from(const TileSums& sums, const Splat& s, const unsigned char* records, std::size_t count) {
  if constexpr (kVectors * kWidth < 3 * image::kMaxFootprint) {
    if (kVectors * kWidth < 3 * s.size) return splat_from<kVectors + 1>(sums, s, records, count);
  }
  splat_rows<kVectors>(sums, s, records, count);
}

void splat_any(const TileSums& sums, const Splat& s, const unsigned char* records, std::size_t count) {
  splat_from<1>(sums, s, records, count);
}

std::uint32_t brightest(const TileSums& sums, int rows, int lanes) {
  std::uint32_t most = 0;
  for (int row = 0; row < rows; ++row) {
    const std::uint32_t* light = sums.light + static_cast<std::ptrdiff_t>(row) * sums.stride;
    int i = 0;
    Uints greatest{};
    for (; i + kWidth <= lanes; i += kWidth) {
      const Uints v = load_uints(light + i);
      const Uints more = (Uints)(v > greatest);
      greatest = (v & more) | (greatest & ~more);
    }
    for (int lane = 0; lane < kWidth; ++lane) most = greatest[lane] > most ? greatest[lane] : most;
    for (; i < lanes; ++i) most = light[i] > most ? light[i] : most;
  }
  return most;
}

void start(std::uint32_t* light, const std::uint16_t* scenery, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) light[i] = static_cast<std::uint32_t>(scenery[i]) << image::kSceneryShift;
}

// The exponent and first mantissa bits of a float form a logarithm in steps. Halved, a sum fits a signed integer.
MOTES_INLINE Ints tone_index(Uints light) {
  const Ints bits = (Ints)to_floats((Ints)(light >> 1));
  const Ints index = (bits >> (23 - image::kToneBits)) - (127 << image::kToneBits);
  return index & (index > 0);
}

void tone(const std::uint32_t* light, std::size_t count, const std::uint8_t* table, std::uint8_t* to) {
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    const Ints index = tone_index(load_uints(light + i));
#if MOTES_WIDTH == 512
    // Reads four bytes per entry: the table is longer than its greatest index.
    const __m512i entries = _mm512_mask_i32gather_epi32(_mm512_setzero_si512(), 0xffff, (__m512i)index, table, 1);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to + i), _mm512_maskz_cvtepi32_epi8(0xffff, entries));
#else
    std::int32_t numbers[kLanes];
    store_mask(numbers, index);
    for (std::size_t lane = 0; lane < kLanes; ++lane) to[i + lane] = table[numbers[lane]];
#endif
  }
  for (; i < count; ++i) to[i] = table[tone_index(all_uints(light[i]))[0]];
}

}  // namespace

extern const image::SplatLanes splat_lanes = {splat_any, brightest, start, tone};

}  // namespace motes::MOTES_ISA
