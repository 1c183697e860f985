// 64-bit ids as vectors, and their halves as vectors of 32-bit integers.
#pragma once

#include "simd/simd.h"

namespace motes::MOTES_ISA {

/// Half as many lanes as Uints has. The upper halves have no meaning.
using Wide = std::uint64_t __attribute__((vector_size(4 * MOTES_LANES)));

/// All lanes, as two vectors: `join` knows which lanes are in which.
struct Wides {
  Wide first, second;
};

/// The upper halves of ids.
MOTES_INLINE Wide upper(Wide v) { return v >> 32; }

/// kLanes ids; their low halves are the integers.
MOTES_INLINE Wides load_ids(const std::uint64_t* ids) {
  Wides v;
#if MOTES_WIDTH == 256
  // 0 1 4 5 and 2 3 6 7: the shuffle of `join` works inside 128-bit halves.
  const auto* from = reinterpret_cast<const __m128i*>(ids);
  v.first = (Wide)_mm256_inserti128_si256(_mm256_castsi128_si256(_mm_loadu_si128(from)), _mm_loadu_si128(from + 2), 1);
  v.second =
      (Wide)_mm256_inserti128_si256(_mm256_castsi128_si256(_mm_loadu_si128(from + 1)), _mm_loadu_si128(from + 3), 1);
#else
  __builtin_memcpy(&v.first, ids, sizeof v.first);
  __builtin_memcpy(&v.second, ids + kLanes / 2, sizeof v.second);
#endif
  return v;
}

/// The integers of all lanes in order.
MOTES_INLINE Uints join(Wides v) {
#if MOTES_WIDTH == 512
  const __m512i even = _mm512_set_epi32(30, 28, 26, 24, 22, 20, 18, 16, 14, 12, 10, 8, 6, 4, 2, 0);
  return (Uints)_mm512_permutex2var_epi32((__m512i)v.first, even, (__m512i)v.second);
#elif MOTES_WIDTH == 256
  return (Uints)_mm256_shuffle_ps((__m256)v.first, (__m256)v.second, 0x88);
#elif MOTES_WIDTH == 128
  return (Uints)_mm_shuffle_ps((__m128)v.first, (__m128)v.second, 0x88);
#else
  Uints joined;
  for (std::size_t i = 0; i < kLanes / 2; ++i) {
    joined[i] = static_cast<std::uint32_t>(v.first[i]);
    joined[i + kLanes / 2] = static_cast<std::uint32_t>(v.second[i]);
  }
  return joined;
#endif
}

/// Whether an integer in any lane has an upper half.
MOTES_INLINE bool any_upper(Wides v) {
  const Wide both = v.first | v.second;
#if MOTES_WIDTH == 512
  return _mm512_test_epi64_mask((__m512i)both, _mm512_set1_epi64(INT64_MIN >> 31)) != 0;
#elif MOTES_WIDTH == 256
  return _mm256_testz_si256((__m256i)both, _mm256_set1_epi64x(INT64_MIN >> 31)) == 0;
#elif MOTES_WIDTH == 128
  return (_mm_movemask_epi8(_mm_cmpeq_epi32((__m128i)both, _mm_setzero_si128())) & 0xF0F0) != 0xF0F0;
#else
  std::uint64_t upper = 0;
  for (std::size_t i = 0; i < kLanes / 2; ++i) upper |= both[i] >> 32;
  return upper != 0;
#endif
}

}  // namespace motes::MOTES_ISA
