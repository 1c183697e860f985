// Four words per lane, which are consecutive in memory.
#pragma once

#include "simd/simd.h"

namespace motes::MOTES_ISA {

/// Four words per lane as vectors, one vector for each of the four.
struct FourWords {
  Uints word[4];
};

#if MOTES_WIDTH != 0
// Interleave words, or pairs of words, of two vectors, from the lower or the upper half of each group of four lanes.
MOTES_INTEGERS(Uints, interleave_low, unpacklo_epi32)
MOTES_INTEGERS(Uints, interleave_high, unpackhi_epi32)
MOTES_INTEGERS(Uints, interleave_low_pairs, unpacklo_epi64)
MOTES_INTEGERS(Uints, interleave_high_pairs, unpackhi_epi64)
#elif MOTES_NEON
MOTES_INLINE Uints interleave_low(Uints a, Uints b) { return __builtin_shufflevector(a, b, 0, 4, 1, 5); }
MOTES_INLINE Uints interleave_high(Uints a, Uints b) { return __builtin_shufflevector(a, b, 2, 6, 3, 7); }
MOTES_INLINE Uints interleave_low_pairs(Uints a, Uints b) { return __builtin_shufflevector(a, b, 0, 1, 4, 5); }
MOTES_INLINE Uints interleave_high_pairs(Uints a, Uints b) { return __builtin_shufflevector(a, b, 2, 3, 6, 7); }
#endif

#if MOTES_WIDTH != 0 || MOTES_NEON
/// Transposes each group of four lanes: lane 4 * p + r of vector c becomes lane 4 * p + c of vector r.
MOTES_INLINE FourWords transposed(const FourWords& v) {
  const Uints first = interleave_low(v.word[0], v.word[1]), second = interleave_low(v.word[2], v.word[3]);
  const Uints third = interleave_high(v.word[0], v.word[1]), fourth = interleave_high(v.word[2], v.word[3]);
  return {{interleave_low_pairs(first, second), interleave_high_pairs(first, second),
           interleave_low_pairs(third, fourth), interleave_high_pairs(third, fourth)}};
}
#endif

/// Four words per lane as in memory.
struct Quads {
  std::uint32_t word[kLanes][4];
};
MOTES_INLINE Quads quads_of(Uints a, Uints b, Uints c, Uints d) {
  Quads quads;
#if MOTES_WIDTH != 0 || MOTES_NEON
  // Part p of row r has the four words of lane 4 * p + r.
  const FourWords rows = transposed({{a, b, c, d}});
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    __builtin_memcpy(quads.word[lane], reinterpret_cast<const std::uint32_t*>(&rows.word[lane % 4]) + lane / 4 * 4, 16);
  }
#else
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    quads.word[lane][0] = a[lane];
    quads.word[lane][1] = b[lane];
    quads.word[lane][2] = c[lane];
    quads.word[lane][3] = d[lane];
  }
#endif
  return quads;
}

#if MOTES_WIDTH != 0
/// Loads `kWords` words, three or four, from an address; reads no more.
template <int kWords>
MOTES_INLINE __m128i load_words(const void* from) {
  if (kWords == 4) return _mm_loadu_si128(static_cast<const __m128i*>(from));
#if MOTES_WIDTH == 512
  return _mm_maskz_loadu_epi32(7, from);
#else
  int last;
  __builtin_memcpy(&last, static_cast<const unsigned char*>(from) + 8, sizeof last);
  return _mm_unpacklo_epi64(_mm_loadl_epi64(static_cast<const __m128i*>(from)), _mm_cvtsi32_si128(last));
#endif
}

/// Loads the words at `at(lane)`, a pointer to bytes, as rows: part p of row r has those of lane 4 * p + r.
template <int kWords = 4, class At>
MOTES_INLINE FourWords load_rows(const At& at) {
  const auto four = [&](std::size_t lane) { return load_words<kWords>(at(lane)); };
  FourWords rows;
  for (std::size_t r = 0; r < 4; ++r) {
#if MOTES_WIDTH == 512
    __m512i parts = _mm512_castsi128_si512(four(r));
    parts = _mm512_inserti32x4(parts, four(4 + r), 1);
    parts = _mm512_inserti32x4(parts, four(8 + r), 2);
    rows.word[r] = (Uints)_mm512_inserti32x4(parts, four(12 + r), 3);
#elif MOTES_WIDTH == 256
    rows.word[r] = (Uints)_mm256_inserti128_si256(_mm256_castsi128_si256(four(r)), four(4 + r), 1);
#else
    rows.word[r] = (Uints)four(r);
#endif
  }
  return rows;
}
#endif

/// Loads the words at `at(lane)`, a pointer to bytes. With three words, the fourth is undefined.
template <int kWords, class At>
MOTES_INLINE FourWords load_each(const At& at) {
#if MOTES_WIDTH != 0
  return transposed(load_rows<kWords>(at));
#elif MOTES_NEON
  FourWords rows;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    std::uint64_t first, last = 0;
    __builtin_memcpy(&first, at(lane), sizeof first);
    __builtin_memcpy(&last, reinterpret_cast<const unsigned char*>(at(lane)) + sizeof first, 4 * (kWords - 2));
    rows.word[lane] = (Uints)vcombine_u64(vcreate_u64(first), vcreate_u64(last));
  }
  return transposed(rows);
#else
  FourWords v{};
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    std::uint32_t words[kWords];
    __builtin_memcpy(words, at(lane), sizeof words);
    for (int w = 0; w < kWords; ++w) v.word[w][lane] = words[w];
  }
  return v;
#endif
}
template <class At>
MOTES_INLINE FourWords load_fours(const At& at) {
  return load_each<4>(at);
}
template <class At>
MOTES_INLINE FourWords load_threes(const At& at) {
  return load_each<3>(at);
}

/// Loads the eight 16-bit numbers at `at(lane)`: word k has number k in its lower half and number k + 4 in its upper
/// half.
template <class At>
MOTES_INLINE FourWords load_pairs(const At& at) {
#if MOTES_WIDTH != 0
  FourWords rows = load_rows(at);
  for (Uints& row : rows.word) {
#if MOTES_WIDTH == 128
    row = (Uints)_mm_unpacklo_epi16((__m128i)row, _mm_srli_si128((__m128i)row, 8));
#else
    const __m128i in_turn = _mm_setr_epi8(0, 1, 8, 9, 2, 3, 10, 11, 4, 5, 12, 13, 6, 7, 14, 15);
#if MOTES_WIDTH == 512
    row = (Uints)_mm512_shuffle_epi8((__m512i)row, _mm512_maskz_broadcast_i32x4(0xffff, in_turn));
#else
    row = (Uints)_mm256_shuffle_epi8((__m256i)row, _mm256_broadcastsi128_si256(in_turn));
#endif
#endif
  }
  return transposed(rows);
#else
  const FourWords v = load_fours(at);
  const auto low = [](Uints first, Uints second) { return (first & 0xffffu) | second << 16; };
  const auto high = [](Uints first, Uints second) { return first >> 16 | (second & 0xffff0000u); };
  return {
      {low(v.word[0], v.word[2]), high(v.word[0], v.word[2]), low(v.word[1], v.word[3]), high(v.word[1], v.word[3])}};
#endif
}

}  // namespace motes::MOTES_ISA
