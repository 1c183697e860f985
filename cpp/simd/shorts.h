// A vector of 16-bit lanes, twice as many as floats: fixed-point arithmetic with the same bits on every instruction
// set.
#pragma once

#include "simd/quads.h"
#include "simd/simd.h"

namespace motes::MOTES_ISA {

inline constexpr int kShorts = 2 * MOTES_LANES;
using Shorts = std::int16_t __attribute__((vector_size(4 * MOTES_LANES)));

MOTES_INLINE Shorts all_shorts(int value) { return Shorts{} + static_cast<std::int16_t>(value); }
MOTES_INLINE void store_shorts(std::uint16_t* to, Shorts v) { __builtin_memcpy(to, &v, sizeof v); }

#if MOTES_WIDTH != 0
/// Saturating sums.
MOTES_INTEGERS(Shorts, add_saturating, adds_epi16)
/// Saturating differences of unsigned numbers.
MOTES_INTEGERS(Shorts, subtract_to_zero, subs_epu16)
MOTES_INTEGERS(Shorts, min_shorts, min_epi16)
MOTES_INTEGERS(Shorts, max_shorts, max_epi16)
/// The upper halves of products of signed and of unsigned numbers.
MOTES_INTEGERS(Shorts, multiply_high, mulhi_epi16)
MOTES_INTEGERS(Shorts, multiply_high_unsigned, mulhi_epu16)
#elif MOTES_NEON
MOTES_INLINE Shorts add_saturating(Shorts a, Shorts b) { return (Shorts)vqaddq_s16((int16x8_t)a, (int16x8_t)b); }
MOTES_INLINE Shorts subtract_to_zero(Shorts a, Shorts b) { return (Shorts)vqsubq_u16((uint16x8_t)a, (uint16x8_t)b); }
MOTES_INLINE Shorts min_shorts(Shorts a, Shorts b) { return (Shorts)vminq_s16((int16x8_t)a, (int16x8_t)b); }
MOTES_INLINE Shorts max_shorts(Shorts a, Shorts b) { return (Shorts)vmaxq_s16((int16x8_t)a, (int16x8_t)b); }
MOTES_INLINE Shorts multiply_high(Shorts a, Shorts b) {
  const auto x = (int16x8_t)a, y = (int16x8_t)b;
  const int32x4_t low = vmull_s16(vget_low_s16(x), vget_low_s16(y)), high = vmull_high_s16(x, y);
  return (Shorts)vuzp2q_s16((int16x8_t)low, (int16x8_t)high);
}
MOTES_INLINE Shorts multiply_high_unsigned(Shorts a, Shorts b) {
  const auto x = (uint16x8_t)a, y = (uint16x8_t)b;
  const uint32x4_t low = vmull_u16(vget_low_u16(x), vget_low_u16(y)), high = vmull_high_u16(x, y);
  return (Shorts)vuzp2q_u16((uint16x8_t)low, (uint16x8_t)high);
}
#else
template <class Do>
MOTES_INLINE Shorts each_short(Shorts a, Shorts b, const Do& what) {
  Shorts v;
  for (int i = 0; i < kShorts; ++i) v[i] = static_cast<std::int16_t>(what(std::int32_t{a[i]}, std::int32_t{b[i]}));
  return v;
}
MOTES_INLINE Shorts add_saturating(Shorts a, Shorts b) {
  return each_short(a, b, [](int x, int y) { return x + y > 32767 ? 32767 : x + y < -32768 ? -32768 : x + y; });
}
MOTES_INLINE Shorts subtract_to_zero(Shorts a, Shorts b) {
  return each_short(a, b, [](int x, int y) { return (x & 0xffff) > (y & 0xffff) ? x - y : 0; });
}
MOTES_INLINE Shorts min_shorts(Shorts a, Shorts b) {
  return each_short(a, b, [](int x, int y) { return x < y ? x : y; });
}
MOTES_INLINE Shorts max_shorts(Shorts a, Shorts b) {
  return each_short(a, b, [](int x, int y) { return x > y ? x : y; });
}
MOTES_INLINE Shorts multiply_high(Shorts a, Shorts b) {
  return each_short(a, b, [](int x, int y) { return x * y >> 16; });
}
MOTES_INLINE Shorts multiply_high_unsigned(Shorts a, Shorts b) {
  return each_short(a, b, [](int x, int y) {
    return static_cast<int>(static_cast<unsigned>(x & 0xffff) * static_cast<unsigned>(y & 0xffff) >> 16);
  });
}
#endif

/// Stores the numbers as 16 bits each; they must fit.
template <class Number>
MOTES_INLINE void store_narrow(Number* to, Ints v) {
  static_assert(sizeof(Number) == 2);
#if MOTES_WIDTH == 512
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm512_maskz_cvtepi32_epi16(0xffff, (__m512i)v));
#elif MOTES_WIDTH == 256
  const __m256i pairs = _mm256_packs_epi32((__m256i)v, (__m256i)v);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm256_castsi256_si128(_mm256_permute4x64_epi64(pairs, 0x08)));
#elif MOTES_WIDTH == 128
  _mm_storel_epi64(reinterpret_cast<__m128i*>(to), _mm_packs_epi32((__m128i)v, (__m128i)v));
#elif MOTES_NEON
  const int16x4_t narrow = vmovn_s32((int32x4_t)v);
  __builtin_memcpy(to, &narrow, sizeof narrow);
#else
  for (std::size_t i = 0; i < kLanes; ++i) to[i] = static_cast<Number>(v[i]);
#endif
}

#if MOTES_WIDTH == 256 || MOTES_WIDTH == 128
// In each group of four lanes: `pack` concatenates the numbers of two vectors as 16 bits each, `in_turn` interleaves
// the 16-bit numbers of the lower and the upper half.
MOTES_INTEGERS(Ints, pack, packs_epi32)
MOTES_INTEGERS(Ints, interleave_low_shorts, unpacklo_epi16)
MOTES_INLINE Ints in_turn(Ints v) { return interleave_low_shorts(v, (Ints)interleave_high_pairs((Uints)v, (Uints)v)); }
#endif

/// Stores three numbers per lane consecutively as 16 bits each; they must fit and not be negative. May overwrite one
/// number behind them.
MOTES_INLINE void store_thirds(std::uint16_t* to, Ints a, Ints b, Ints c) {
#if MOTES_WIDTH == 512
  const auto narrow = [](Ints v) { return _mm512_maskz_cvtepi32_epi16(0xffff, (__m512i)v); };
  const __m512i two = _mm512_inserti64x4(_mm512_castsi256_si512(narrow(a)), narrow(b), 1);
  const __m512i third = _mm512_castsi256_si512(narrow(c));
  // Number n is of lane n / 3. Its index is n / 3 if it is of `a`, 16 more for `b` and 32 more for `c`.
  using Numbers = std::uint16_t __attribute__((vector_size(64)));
  Numbers first, last{};
  for (int n = 0; n < 32; ++n) first[n] = static_cast<std::uint16_t>(n % 3 * 16 + n / 3);
  for (int n = 32; n < 48; ++n) last[n - 32] = static_cast<std::uint16_t>(n % 3 * 16 + n / 3);
  _mm512_storeu_si512(to, _mm512_permutex2var_epi16(two, (__m512i)first, third));
  const __m512i rest = _mm512_permutex2var_epi16(two, (__m512i)last, third);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + 32), _mm512_castsi512_si256(rest));
#elif MOTES_WIDTH != 0
  // Writes the three numbers of each lane and a fourth one, which the next lane overwrites. Each group of four lanes
  // holds the numbers of two.
  const Ints ab = in_turn(pack(a, b)), c0 = in_turn(pack(c, Ints{}));
  const Uints lower = interleave_low((Uints)ab, (Uints)c0), upper = interleave_high((Uints)ab, (Uints)c0);
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const Uints& four = lane % 4 < 2 ? lower : upper;
    __builtin_memcpy(to + 3 * lane, reinterpret_cast<const std::uint64_t*>(&four) + lane / 4 * 2 + lane % 2, 8);
  }
#elif MOTES_NEON
  vst3_u16(to, {{vmovn_u32((uint32x4_t)a), vmovn_u32((uint32x4_t)b), vmovn_u32((uint32x4_t)c)}});
#else
  for (std::size_t i = 0; i < kLanes; ++i) {
    to[3 * i] = static_cast<std::uint16_t>(a[i]);
    to[3 * i + 1] = static_cast<std::uint16_t>(b[i]);
    to[3 * i + 2] = static_cast<std::uint16_t>(c[i]);
  }
#endif
}

/// Loads kShorts / 8 numbers and repeats each in eight lanes.
MOTES_INLINE Shorts by_eights(const std::int16_t* from) {
#if MOTES_WIDTH == 512
  const __m512i four = _mm512_maskz_broadcastq_epi64(0xff, _mm_loadl_epi64(reinterpret_cast<const __m128i*>(from)));
  const __m512i of = _mm512_set_epi64(0x0706070607060706, 0x0706070607060706, 0x0504050405040504, 0x0504050405040504,
                                      0x0302030203020302, 0x0302030203020302, 0x0100010001000100, 0x0100010001000100);
  return (Shorts)_mm512_shuffle_epi8(four, of);
#elif MOTES_WIDTH == 256
  std::int32_t two;
  __builtin_memcpy(&two, from, sizeof two);
  const __m256i of = _mm256_set_epi64x(0x0302030203020302, 0x0302030203020302, 0x0100010001000100, 0x0100010001000100);
  return (Shorts)_mm256_shuffle_epi8(_mm256_set1_epi32(two), of);
#else
  return all_shorts(*from);
#endif
}
/// Loads eight numbers and repeats them across the vector.
MOTES_INLINE Shorts eight_again(const std::int16_t* from) {
#if MOTES_WIDTH == 512
  return (Shorts)_mm512_maskz_broadcast_i32x4(0xffff, _mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
#elif MOTES_WIDTH == 256
  return (Shorts)_mm256_broadcastsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
#else
  Shorts v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
#endif
}

/// Returns, per lane, the product of the lower 16-bit halves plus the product of the upper ones.
#if MOTES_WIDTH != 0
MOTES_INTEGERS(Ints, pair_products, madd_epi16)
#else
MOTES_INLINE Ints pair_products(Ints a, Ints b) { return (a << 16 >> 16) * (b << 16 >> 16) + (a >> 16) * (b >> 16); }
#endif

/// Returns the sums of neighbouring lanes.
MOTES_INLINE Uints pair_sums(Shorts v) {
#if MOTES_WIDTH == 512
  return (Uints)_mm512_madd_epi16((__m512i)v, _mm512_set1_epi16(1));
#elif MOTES_WIDTH == 256
  return (Uints)_mm256_madd_epi16((__m256i)v, _mm256_set1_epi16(1));
#elif MOTES_WIDTH == 128
  return (Uints)_mm_madd_epi16((__m128i)v, _mm_set1_epi16(1));
#elif MOTES_NEON
  return (Uints)vpaddlq_s16((int16x8_t)v);
#else
  Uints sums;
  for (std::size_t i = 0; i < kLanes; ++i) sums[i] = static_cast<std::uint32_t>(v[2 * i] + v[2 * i + 1]);
  return sums;
#endif
}

MOTES_INLINE std::uint32_t sum_of(Uints v) {
#if MOTES_WIDTH == 512
  return static_cast<std::uint32_t>(_mm512_reduce_add_epi32((__m512i)v));
#elif MOTES_WIDTH >= 128
#if MOTES_WIDTH == 256
  __m128i four = _mm_add_epi32(_mm256_castsi256_si128((__m256i)v), _mm256_extracti128_si256((__m256i)v, 1));
#else
  __m128i four = (__m128i)v;
#endif
  four = _mm_add_epi32(four, _mm_shuffle_epi32(four, 0x4e));
  return static_cast<std::uint32_t>(_mm_cvtsi128_si32(_mm_add_epi32(four, _mm_shuffle_epi32(four, 0xb1))));
#elif MOTES_NEON
  return vaddvq_u32((uint32x4_t)v);
#else
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < kLanes; ++i) sum += v[i];
  return sum;
#endif
}

/// Returns the largest of numbers that are not negative.
MOTES_INLINE int greatest_of(Shorts v) {
#if MOTES_WIDTH != 0
  // Takes the maximum of both halves until eight numbers are left, then of 32-bit words until two numbers are left.
#if MOTES_WIDTH == 512
  const __m256i sixteen =
      _mm256_max_epi16(_mm512_castsi512_si256((__m512i)v), _mm512_extracti64x4_epi64((__m512i)v, 1));
  __m128i eight = _mm_max_epi16(_mm256_castsi256_si128(sixteen), _mm256_extracti128_si256(sixteen, 1));
#elif MOTES_WIDTH == 256
  __m128i eight = _mm_max_epi16(_mm256_castsi256_si128((__m256i)v), _mm256_extracti128_si256((__m256i)v, 1));
#else
  __m128i eight = (__m128i)v;
#endif
  eight = _mm_max_epi16(eight, _mm_shuffle_epi32(eight, 0x4e));
  eight = _mm_max_epi16(eight, _mm_shuffle_epi32(eight, 0xb1));
  const int two = _mm_cvtsi128_si32(eight), first = two & 0xffff, second = two >> 16;
  return first > second ? first : second;
#elif MOTES_NEON
  return vmaxvq_s16((int16x8_t)v);
#else
  int most = 0;
  for (int i = 0; i < kShorts; ++i) most = v[i] > most ? v[i] : most;
  return most;
#endif
}

}  // namespace motes::MOTES_ISA
