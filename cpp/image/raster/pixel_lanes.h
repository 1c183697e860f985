// Helpers of a tile painter's kernels. A pixel has three lanes in light (red, green, blue) and one in everything else.
#pragma once

#include "image/balls/surface_words.h"
#include "image/tile_planes.h"
#include "simd/doubles.h"
#include "simd/floats3.h"
#include "simd/simd.h"

namespace motes::MOTES_ISA {

inline constexpr int kWidth = static_cast<int>(kLanes);

// Loads one byte per lane.
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

// A record's light, colour * alpha / 16 (12 bits per channel), as three vectors of lanes:
//
//   part[0] part[1] part[2] = r g b r g b r g b ...
struct RecordLight {
  Uints part[3];
};

#if MOTES_WIDTH == 512 || MOTES_WIDTH == 256
// Byte shuffles: lane l of vector j takes byte (l + kWidth * j) % 3 of the colour, and zeros.
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
// Returns vector j of colour * alpha, in the order of Light.
MOTES_INLINE Uints products_of(const Channels& channels, std::uint32_t color, int j) {
  const Uints word = all_uints(color);
#if MOTES_WIDTH == 512
  const Uints bytes = (Uints)_mm512_shuffle_epi8((__m512i)word, (__m512i)channels.part[j]);
#else
  const Uints bytes = (Uints)_mm256_shuffle_epi8((__m256i)word, (__m256i)channels.part[j]);
#endif
  return multiply_short(bytes, word >> 24);
}
#else
struct Channels {};
MOTES_INLINE Channels channels() { return {}; }
MOTES_INLINE Uints products_of(const Channels&, std::uint32_t color, int j) {
  const std::uint32_t alpha = color >> 24;
  const std::uint32_t r = (color & 0xffu) * alpha, g = (color >> 8 & 0xffu) * alpha, b = (color >> 16 & 0xffu) * alpha;
  static_assert(kLanes == 4);
  return j == 0 ? Uints{r, g, b, r} : j == 1 ? Uints{g, b, r, g} : Uints{b, r, g, b};
}
#endif
MOTES_INLINE RecordLight light_of(const Channels& channels, std::uint32_t color) {
  RecordLight light;
  for (int j = 0; j < 3; ++j) light.part[j] = (products_of(channels, color, j) + 8u) >> 4;
  return light;
}

template <bool kSaturating>
MOTES_INLINE void add(std::uint32_t* to, Uints more) {
  const Uints before = load_uints(to);
  Uints sum = before + more;
  if (kSaturating) sum |= (Uints)(sum < before);
  store_uints(to, sum);
}

// Adds the rows of a record that nothing hides to the light at `to`.
template <int kVectors, bool kSaturating>
MOTES_INLINE void add_rows(int size, int row_bytes, const RecordLight& light, const std::uint8_t* weights,
                           std::uint32_t* to) {
  for (int row = 0; row < size; ++row, to += image::kLightStride, weights += row_bytes) {
    for (int j = 0; j < kVectors; ++j) {
      add<kSaturating>(to + j * kWidth, multiply_short(load_bytes(weights + j * kWidth), light.part[j % 3]));
    }
  }
}

MOTES_INLINE std::uint32_t word_at(const unsigned char* from) {
  std::uint32_t word;
  __builtin_memcpy(&word, from, sizeof word);
  return word;
}

// Spreads one value per pixel over three lanes: lane l of vector j takes pixel (l + kWidth * j) / 3.
#if MOTES_WIDTH >= 256
struct Spread {
  Uints from[3];
};
MOTES_INLINE Spread spread() {
  Spread s;
  for (int j = 0; j < 3; ++j) {
    for (int lane = 0; lane < kWidth; ++lane) {
      s.from[j][lane] = static_cast<std::uint32_t>((lane + kWidth * j) / 3 - kWidth * j / 3);
    }
  }
  return s;
}
MOTES_INLINE Uints spread(const Spread& s, Uints pixels, int j) {
#if MOTES_WIDTH == 512
  return (Uints)_mm512_maskz_permutexvar_epi32(0xffff, (__m512i)s.from[j], (__m512i)pixels);
#else
  return (Uints)_mm256_permutevar8x32_epi32((__m256i)pixels, (__m256i)s.from[j]);
#endif
}
#else
struct Spread {};
MOTES_INLINE Spread spread() { return {}; }
MOTES_INLINE Uints spread(const Spread&, Uints p, int j) {
  static_assert(kLanes == 4);
  return j == 0   ? Uints{p[0], p[0], p[0], p[1]}
         : j == 1 ? Uints{p[0], p[0], p[1], p[1]}
                  : Uints{p[0], p[1], p[1], p[1]};
}
#endif
// Loads vector j of values spread over three lanes per pixel; `pixels` is the first pixel's value. At most half a
// vector of pixels is needed, and half a vector crosses a cache line half as often.
MOTES_INLINE Uints load_spread(const Spread& s, const std::uint32_t* pixels, int j) {
#if MOTES_WIDTH == 512
  const __m256i half = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(pixels + kWidth * j / 3));
  return spread(s, (Uints)_mm512_castsi256_si512(half), j % 3);
#elif MOTES_WIDTH == 256
  const __m128i half = _mm_loadu_si128(reinterpret_cast<const __m128i*>(pixels + kWidth * j / 3));
  return spread(s, (Uints)_mm256_castsi128_si256(half), j % 3);
#else
  return spread(s, load_uints(pixels + kWidth * j / 3), j % 3);
#endif
}

// Returns the light of something at `depth` where the surface `here` is not nearer, 0 elsewhere. Depths are bits of
// positive floats.
MOTES_INLINE Uints where_seen(Uints light, Uints here, Uints depth) {
#if MOTES_WIDTH == 512
  return (Uints)_mm512_maskz_mov_epi32(_mm512_cmpge_epi32_mask((__m512i)here, (__m512i)depth), (__m512i)light);
#else
  return light & (Uints)((Ints)here >= (Ints)depth);
#endif
}

// Returns light * opacity / 65536, rounded down, from products of 16-bit halves (light = h l):
//
//   high = [h * opacity >> 16 | l * opacity >> 16],  low = [h * opacity & 0xffff | ...];  sum = high + (low >> 16)
#if MOTES_WIDTH == 512
MOTES_INLINE __m512i covered(__m512i light, __m512i opacity) {
  const __m512i halves = _mm512_broadcast_i32x4(_mm_setr_epi8(0, 1, 0, 1, 4, 5, 4, 5, 8, 9, 8, 9, 12, 13, 12, 13));
  const __m512i both = _mm512_shuffle_epi8(opacity, halves);
  const __m512i high = _mm512_mulhi_epu16(light, both), low = _mm512_mullo_epi16(light, both);
  return _mm512_add_epi32(high, _mm512_srli_epi32(low, 16));
}
#endif
#if MOTES_WIDTH >= 256
MOTES_INLINE __m256i covered(__m256i light, __m256i opacity) {
  const __m256i halves = _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 1, 0, 1, 4, 5, 4, 5, 8, 9, 8, 9, 12, 13, 12, 13));
  const __m256i both = _mm256_shuffle_epi8(opacity, halves);
  const __m256i high = _mm256_mulhi_epu16(light, both), low = _mm256_mullo_epi16(light, both);
  return _mm256_add_epi32(high, _mm256_srli_epi32(low, 16));
}
#elif MOTES_WIDTH == 128
MOTES_INLINE __m128i covered(__m128i light, __m128i opacity) {
  const __m128i both = _mm_or_si128(opacity, _mm_slli_epi32(opacity, 16));
  const __m128i high = _mm_mulhi_epu16(light, both), low = _mm_mullo_epi16(light, both);
  return _mm_add_epi32(high, _mm_srli_epi32(low, 16));
}
#endif

// Returns the light that remains behind something of this opacity (0..65535): light - light * opacity / 65536, rounded
// up, exact for any 32 bits.
template <class Vector>
MOTES_INLINE Vector behind(Vector light, Vector opacity) {
#if MOTES_WIDTH == 512
  if constexpr (sizeof(Vector) == sizeof(__m512i)) return light - (Vector)covered((__m512i)light, (__m512i)opacity);
#endif
#if MOTES_WIDTH >= 256
  if constexpr (sizeof(Vector) == sizeof(__m256i)) return light - (Vector)covered((__m256i)light, (__m256i)opacity);
#elif MOTES_WIDTH == 128
  if constexpr (sizeof(Vector) == sizeof(__m128i)) return light - (Vector)covered((__m128i)light, (__m128i)opacity);
#endif
  return light - (light >> 16) * opacity - ((light & 0xffffu) * opacity >> 16);
}

// Returns the opacity, 0..65535, of alpha * weight (0..255 each): 255 * 255 becomes 65533.
MOTES_INLINE Uints opacity_of(Uints alpha_weight) { return alpha_weight + (alpha_weight >> 7); }

// Returns the part, 0..4096, of a soft particle's light that remains in front of a surface at depth `wall`. 4096 times
// a record's greatest light, 4064 * 255, fits into 32 bits.
MOTES_INLINE Uints faded(Uints wall, std::uint32_t depth, float fade) {
  float center;
  __builtin_memcpy(&center, &depth, sizeof center);
  const Floats room = ((Floats)wall - all(center)) * all(fade);
  return (Uints)to_ints(min(max(room, Floats{}), all(1.0f)) * all(4096.0f) + all(0.5f));
}

// Returns where faded() keeps all light, for this surface and any farther one.
MOTES_INLINE Mask keeps_all(Floats wall, Floats depth, float fade) { return (wall - depth) * all(fade) >= 1.0f; }

// Least depth, m: a sphere's front may reach behind the camera, but depths must stay positive.
inline constexpr float kLeastDepth = 1e-6f;

inline constexpr int kLongs = kWidth / 2;

MOTES_INLINE Longs all_longs(image::NearestSurface value) { return Longs{} + static_cast<std::int64_t>(value); }
MOTES_INLINE Longs load_longs(const image::NearestSurface* from) {
  Longs v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}

// Keeps the smaller of both numbers at each of kLongs pixels whose bit of `covered` is set. All numbers are positive.
MOTES_INLINE void keep_nearest(image::NearestSurface* to, Longs more, unsigned covered) {
#if MOTES_WIDTH == 512
  const Longs before = load_longs(to);
  _mm512_storeu_si512(
      to, _mm512_mask_min_epu64((__m512i)before, static_cast<__mmask8>(covered), (__m512i)before, (__m512i)more));
#elif MOTES_WIDTH == 256
  const Longs before = in_register(load_longs(to));
  const Longs bits = {1, 2, 4, 8};
  const Longs wins = (before > more) & (((Longs{} + static_cast<std::int64_t>(covered)) & bits) == bits);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                      _mm256_blendv_epi8((__m256i)before, (__m256i)more, (__m256i)wins));
#else
  const Longs before = load_longs(to);
  for (int lane = 0; lane < kLongs; ++lane) {
    const auto old = static_cast<image::NearestSurface>(before[lane]),
               here = static_cast<image::NearestSurface>(more[lane]);
    if ((covered >> lane & 1u) != 0 && here < old) to[lane] = here;
  }
#endif
}

// Combines depths and surfaces of pixels into numbers of type Nearest; `half` selects the lower or upper half of the
// lanes.
MOTES_INLINE Longs nearest_of(Uints depth, Uints surface, int half) {
#if MOTES_WIDTH == 512
  // Interleaves words of `surface` and `depth`, from the lower or the upper half of both.
  const __m512i lower = _mm512_set_epi32(23, 7, 22, 6, 21, 5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0);
  const __m512i of = half == 0 ? lower : _mm512_add_epi32(lower, _mm512_set1_epi32(8));
  return (Longs)_mm512_permutex2var_epi32((__m512i)surface, of, (__m512i)depth);
#elif MOTES_WIDTH == 256
  // unpack works within each 128-bit half: lanes 0, 1, 4, 5 or 2, 3, 6, 7.
  const __m256i low = _mm256_unpacklo_epi32((__m256i)surface, (__m256i)depth);
  const __m256i high = _mm256_unpackhi_epi32((__m256i)surface, (__m256i)depth);
  return (Longs)(half == 0 ? _mm256_permute2x128_si256(low, high, 0x20) : _mm256_permute2x128_si256(low, high, 0x31));
#else
  Longs v;
  for (int lane = 0; lane < kLongs; ++lane) {
    v[lane] = static_cast<std::int64_t>(image::NearestSurface{depth[lane + half * kLongs]} << 32 |
                                        surface[lane + half * kLongs]);
  }
  return v;
#endif
}

// Splits interleaved words, such as surfaces and depths of pixels, into two vectors.
#if MOTES_WIDTH == 512
MOTES_INLINE void split(__m512i low, __m512i high, Uints& first, Uints& second) {
  const __m512i even = _mm512_set_epi32(30, 28, 26, 24, 22, 20, 18, 16, 14, 12, 10, 8, 6, 4, 2, 0);
  first = (Uints)_mm512_permutex2var_epi32(low, even, high);
  second = (Uints)_mm512_permutex2var_epi32(low, _mm512_add_epi32(even, _mm512_set1_epi32(1)), high);
}
#endif
MOTES_INLINE void split(const void* words, Uints& first, Uints& second) {
  const auto* from = static_cast<const image::NearestSurface*>(words);
#if MOTES_WIDTH == 512
  split(_mm512_loadu_si512(from), _mm512_loadu_si512(from + kLongs), first, second);
#elif MOTES_WIDTH == 256
  // Takes words 0, 2 or 1, 3 of each half of both vectors, then puts the halves in order.
  const __m256 low = _mm256_loadu_ps(reinterpret_cast<const float*>(from));
  const __m256 high = _mm256_loadu_ps(reinterpret_cast<const float*>(from + kLongs));
  first = (Uints)_mm256_permute4x64_pd((__m256d)_mm256_shuffle_ps(low, high, 0x88), 0xd8);
  second = (Uints)_mm256_permute4x64_pd((__m256d)_mm256_shuffle_ps(low, high, 0xdd), 0xd8);
#else
  for (int lane = 0; lane < kWidth; ++lane) {
    std::uint32_t pair[2];
    __builtin_memcpy(pair, from + lane, sizeof pair);
    first[lane] = pair[0];
    second[lane] = pair[1];
  }
#endif
}

#if MOTES_WIDTH == 512
// Loads the first and the last words of records of three words. Records 0..10 begin in the first two vectors.
MOTES_INLINE void split_thirds(const unsigned char* records, Uints& first, Uints& last) {
  const __m512i low = _mm512_loadu_si512(records), middle = _mm512_loadu_si512(records + 64),
                high = _mm512_loadu_si512(records + 128);
  const __m512i begins = _mm512_set_epi32(0, 0, 0, 0, 0, 30, 27, 24, 21, 18, 15, 12, 9, 6, 3, 0);
  const __m512i begins_high = _mm512_set_epi32(29, 26, 23, 20, 17, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
  const __m512i ends = _mm512_set_epi32(0, 0, 0, 0, 0, 0, 29, 26, 23, 20, 17, 14, 11, 8, 5, 2);
  const __m512i ends_high = _mm512_set_epi32(31, 28, 25, 22, 19, 16, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
  first = (Uints)_mm512_permutex2var_epi32(_mm512_permutex2var_epi32(low, begins, middle), begins_high, high);
  last = (Uints)_mm512_permutex2var_epi32(_mm512_permutex2var_epi32(low, ends, middle), ends_high, high);
}
#endif

}  // namespace motes::MOTES_ISA
