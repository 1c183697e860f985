// A vector of lanes: one source, compiled once for each instruction set.
//
// Files that include this header are compiled with MOTES_ISA = sse2 | avx2 | avx512 | neon (see cpp/CMakeLists.txt).
// Everything that depends on the width lives in namespace motes::MOTES_ISA, so the builds never share a symbol.
// Two rules ensure bit-identical results and that the library runs on old machines:
//   - only lane-wise + - * / sqrt, comparisons, selects and integer operations: no result depends on the width;
//   - no function of the standard library in these files: the linker keeps one copy of an inline function, and it
//     might keep the one that was compiled for a newer processor.
#pragma once

#include <cstddef>
#include <cstdint>

#include "simd/generic.h"

#if defined(__x86_64__) && !defined(MOTES_GENERIC)
#include <immintrin.h>
#elif defined(__aarch64__) && !defined(MOTES_GENERIC)
#include <arm_neon.h>
#endif

#ifndef MOTES_ISA
#define MOTES_ISA sse2
#define MOTES_LANES 4
#endif

// Width in bits of the x86 registers that the intrinsics below use; 0: Arm's, or the compiler's own lane-wise code.
#if defined(MOTES_GENERIC)
#define MOTES_WIDTH 0
#elif defined(__AVX512F__) && MOTES_LANES == 16
#define MOTES_WIDTH 512
#elif defined(__AVX2__) && MOTES_LANES == 8
#define MOTES_WIDTH 256
#elif defined(__x86_64__) && MOTES_LANES == 4
#define MOTES_WIDTH 128
#else
#define MOTES_WIDTH 0
#endif

// Whether Arm's intrinsics are used where compilers do not find the instruction by themselves. What they leave out is
// lane-wise code.
#if defined(__aarch64__) && !defined(MOTES_GENERIC) && MOTES_LANES == 4
#define MOTES_NEON 1
#else
#define MOTES_NEON 0
#endif

#define MOTES_INLINE inline __attribute__((always_inline))
// For functions that are called once for many records or pixels, from several places: compiled once instead of inlined
// into each of them.
#define MOTES_OUTLINE inline __attribute__((noinline))

// Defines `name`, which combines two vectors of integers by the instruction whose intrinsics end in `form`.
#if MOTES_WIDTH == 512
#define MOTES_INTEGERS(Vector, name, form) \
  MOTES_INLINE Vector name(Vector a, Vector b) { return (Vector)_mm512_##form((__m512i)a, (__m512i)b); }
#elif MOTES_WIDTH == 256
#define MOTES_INTEGERS(Vector, name, form) \
  MOTES_INLINE Vector name(Vector a, Vector b) { return (Vector)_mm256_##form((__m256i)a, (__m256i)b); }
#elif MOTES_WIDTH == 128
#define MOTES_INTEGERS(Vector, name, form) \
  MOTES_INLINE Vector name(Vector a, Vector b) { return (Vector)_mm_##form((__m128i)a, (__m128i)b); }
#endif

namespace motes::MOTES_ISA {

inline constexpr std::size_t kLanes = MOTES_LANES;

using Floats = float __attribute__((vector_size(4 * MOTES_LANES)));
using Ints = std::int32_t __attribute__((vector_size(4 * MOTES_LANES)));
using Uints = std::uint32_t __attribute__((vector_size(4 * MOTES_LANES)));
/// All bits of a lane set: true.
using Mask = Ints;

// Returns a vector with one value in every lane.
MOTES_INLINE Floats all(float value) {
#if MOTES_WIDTH == 512
  return (Floats)_mm512_set1_ps(value);
#elif MOTES_WIDTH == 256
  return (Floats)_mm256_set1_ps(value);
#elif MOTES_WIDTH == 128
  return (Floats)_mm_set1_ps(value);
#else
  Floats v;
  for (std::size_t i = 0; i < kLanes; ++i) v[i] = value;
  return v;
#endif
}
MOTES_INLINE Uints all_uints(std::uint32_t value) { return Uints{} + value; }

/// Returns 0, 1, 2, ..., by lane.
MOTES_INLINE Uints lane_numbers() {
  Uints numbers;
  for (std::size_t lane = 0; lane < kLanes; ++lane) numbers[lane] = static_cast<std::uint32_t>(lane);
  return numbers;
}
/// Returns a mask of the first `count` lanes, or of all if there are fewer.
MOTES_INLINE Mask first_lanes(std::size_t count) {
  return (Ints)lane_numbers() < static_cast<std::int32_t>(count < kLanes ? count : kLanes);
}

MOTES_INLINE Floats load(const float* from) {
  Floats v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
/// Stores floats, which cannot alias a pointer or a count, so the compiler need not reload those after each store.
MOTES_INLINE void store(float* to, Floats v) {
  using Anywhere __attribute__((aligned(4))) = Floats;
  *reinterpret_cast<Anywhere*>(to) = v;
}
MOTES_INLINE Mask load_mask(const std::int32_t* from) {
  Mask v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
MOTES_INLINE void store_mask(std::int32_t* to, Mask v) {
  using Anywhere __attribute__((aligned(4))) = Mask;
  *reinterpret_cast<Anywhere*>(to) = v;
}

MOTES_INLINE Uints load_uints(const std::uint32_t* from) {
  Uints v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
MOTES_INLINE void store_uints(std::uint32_t* to, Uints v) {
  using Anywhere __attribute__((aligned(4))) = Uints;
  *reinterpret_cast<Anywhere*>(to) = v;
}

/// Keeps a loaded vector that is used several times in a register: compilers would read it from memory each time, which
/// is slow if it crosses a cache line.
template <class Vector>
MOTES_INLINE Vector in_register(Vector v) {
#if MOTES_WIDTH == 512
  asm("" : "+v"(v));
#elif MOTES_WIDTH != 0
  if constexpr (sizeof v <= MOTES_WIDTH / 8) asm("" : "+x"(v));
#elif MOTES_NEON
  if constexpr (sizeof v == 16) asm("" : "+w"(v));
#endif
  return v;
}

/// Returns a ^ b ^ c: one operation with AVX-512.
MOTES_INLINE Uints xor3(Uints a, Uints b, Uints c) {
#if MOTES_WIDTH == 512
  return (Uints)_mm512_ternarylogic_epi32((__m512i)a, (__m512i)b, (__m512i)c, 0x96);
#else
  return a ^ b ^ c;
#endif
}

MOTES_INLINE Floats select(Mask mask, Floats yes, Floats no) {
#if MOTES_WIDTH == 512
  return (Floats)_mm512_mask_blend_ps(_mm512_movepi32_mask((__m512i)mask), (__m512)no, (__m512)yes);
#elif MOTES_WIDTH == 256
  return (Floats)_mm256_blendv_ps((__m256)no, (__m256)yes, (__m256)mask);
#elif MOTES_NEON
  return (Floats)vbslq_f32((uint32x4_t)mask, (float32x4_t)yes, (float32x4_t)no);
#else
  return (Floats)(((Ints)yes & mask) | ((Ints)no & ~mask));
#endif
}
MOTES_INLINE Ints select(Mask mask, Ints yes, Ints no) { return (Ints)select(mask, (Floats)yes, (Floats)no); }

/// Returns one bit per lane, with the first lane's as the lowest.
MOTES_INLINE unsigned bits_of(Mask mask) {
#if MOTES_WIDTH == 512
  return _mm512_movepi32_mask((__m512i)mask);
#elif MOTES_WIDTH == 256
  return static_cast<unsigned>(_mm256_movemask_ps((__m256)mask));
#elif MOTES_WIDTH == 128
  return static_cast<unsigned>(_mm_movemask_ps((__m128)mask));
#elif MOTES_NEON
  return vaddvq_u32((uint32x4_t)((Uints)mask & Uints{1, 2, 4, 8}));
#else
  unsigned bits = 0;
  for (std::size_t i = 0; i < kLanes; ++i) bits |= static_cast<unsigned>(mask[i] & 1) << i;
  return bits;
#endif
}

/// Returns a mask of the lanes whose bits are set; bits beyond those of the lanes are ignored.
MOTES_INLINE Mask mask_of(unsigned bits) {
#if MOTES_WIDTH == 512
  return (Mask)_mm512_movm_epi32(static_cast<__mmask16>(bits));
#else
  return (Mask)((all_uints(bits) >> lane_numbers() & 1u) != 0u);
#endif
}

#if MOTES_NEON
MOTES_INLINE bool any(Mask mask) { return vmaxvq_u32((uint32x4_t)mask) != 0; }
#else
MOTES_INLINE bool any(Mask mask) { return bits_of(mask) != 0; }
#endif
/// Returns one bit per lane, set where a < b.
MOTES_INLINE unsigned bits_below(Floats a, Floats b) {
#if MOTES_WIDTH == 512  // avoids the mask as a vector, which compilers would make
  return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ);
#else
  return bits_of(a < b);
#endif
}
/// Returns whether v <= limit in every lane; false if one is NaN.
MOTES_INLINE bool all_at_most(Floats v, float limit) {
#if MOTES_WIDTH == 512  // as above
  return _mm512_cmp_ps_mask((__m512)v, _mm512_set1_ps(limit), _CMP_NLE_UQ) == 0;
#else
  return !any(~(v <= limit));
#endif
}

MOTES_INLINE Floats sqrt(Floats v) {
#if MOTES_WIDTH == 512
  return (Floats)_mm512_sqrt_ps((__m512)v);
#elif MOTES_WIDTH == 256
  return (Floats)_mm256_sqrt_ps((__m256)v);
#elif MOTES_WIDTH == 128
  return (Floats)_mm_sqrt_ps((__m128)v);
#elif MOTES_NEON
  return (Floats)vsqrtq_f32((float32x4_t)v);
#else
  for (std::size_t i = 0; i < kLanes; ++i) v[i] = __builtin_sqrtf(v[i]);
  return v;
#endif
}

/// Returns `v` where the mask is true, elsewhere 0: cheaper than a select, which takes three operations on AVX2
/// processors.
MOTES_INLINE Floats only(Mask mask, Floats v) {
#if MOTES_WIDTH == 512
  return (Floats)_mm512_maskz_mov_ps(_mm512_movepi32_mask((__m512i)mask), (__m512)v);
#else
  return (Floats)((Ints)v & mask);
#endif
}

// Return a < b ? a : b and a > b ? a : b, lane by lane: the second operand if either is NaN, like the processors'
// instructions.
MOTES_INLINE Floats min(Floats a, Floats b) {
#if MOTES_WIDTH == 512
  return (Floats)_mm512_min_ps((__m512)a, (__m512)b);
#elif MOTES_WIDTH == 256
  return (Floats)_mm256_min_ps((__m256)a, (__m256)b);
#elif MOTES_WIDTH == 128
  return (Floats)_mm_min_ps((__m128)a, (__m128)b);
#else
  return select(a < b, a, b);
#endif
}
MOTES_INLINE Floats max(Floats a, Floats b) {
#if MOTES_WIDTH == 512
  return (Floats)_mm512_max_ps((__m512)a, (__m512)b);
#elif MOTES_WIDTH == 256
  return (Floats)_mm256_max_ps((__m256)a, (__m256)b);
#elif MOTES_WIDTH == 128
  return (Floats)_mm_max_ps((__m128)a, (__m128)b);
#else
  return select(a > b, a, b);
#endif
}
MOTES_INLINE Ints all_ints(int value) { return Ints{} + value; }
#if MOTES_WIDTH >= 256
MOTES_INTEGERS(Ints, max_ints, max_epi32)
MOTES_INTEGERS(Ints, min_ints, min_epi32)
#elif MOTES_NEON
MOTES_INLINE Ints max_ints(Ints a, Ints b) { return (Ints)vmaxq_s32((int32x4_t)a, (int32x4_t)b); }
MOTES_INLINE Ints min_ints(Ints a, Ints b) { return (Ints)vminq_s32((int32x4_t)a, (int32x4_t)b); }
#else  // SSE2 has no such instructions
MOTES_INLINE Ints max_ints(Ints a, Ints b) { return select(a > b, a, b); }
MOTES_INLINE Ints min_ints(Ints a, Ints b) { return select(a < b, a, b); }
#endif

MOTES_INLINE Floats abs(Floats v) { return (Floats)((Ints)v & 0x7fffffff); }

/// Size of the tables in which `pick` looks up a number with one instruction; 0: there is no such instruction.
#if MOTES_WIDTH >= 256
inline constexpr int kTable = MOTES_LANES;
#else
inline constexpr int kTable = 0;
#endif

/// Returns, in each lane, the table's entry at that lane's index `at`.
MOTES_INLINE Floats pick(Floats table, Ints at) {
#if MOTES_WIDTH == 512
  return (Floats)_mm512_permutexvar_ps((__m512i)at, (__m512)table);
#elif MOTES_WIDTH == 256
  return (Floats)_mm256_permutevar8x32_ps((__m256)table, (__m256i)at);
#else
  Floats v;
  for (std::size_t i = 0; i < kLanes; ++i) v[i] = table[at[i]];
  return v;
#endif
}

/// Returns, in each lane, the number at that lane's index `at`.
MOTES_INLINE Floats gather(const float* from, Ints at) {
#if MOTES_WIDTH == 512
  return (Floats)_mm512_i32gather_ps((__m512i)at, from, 4);
#elif MOTES_WIDTH == 256
  return (Floats)_mm256_i32gather_ps(from, (__m256i)at, 4);
#else
  Floats v;
  for (std::size_t i = 0; i < kLanes; ++i) v[i] = from[at[i]];
  return v;
#endif
}

/// Two numbers per lane that are neighbours in memory.
struct Pair {
  Floats first, second;
};

/// Returns, in each lane, the number at that lane's index `at` and the one behind it, with half the loads of two
/// `gather`s.
MOTES_INLINE Pair gather_pairs(const float* from, Ints at) {
  // Gathered as doubles, since the bits are only moved.
#if MOTES_WIDTH == 512
  const auto* const pairs = reinterpret_cast<const double*>(from);
  const __m512i all = (__m512i)at;
  const auto low = (__m512)_mm512_i32gather_pd(_mm512_castsi512_si256(all), pairs, 4);
  const auto high = (__m512)_mm512_i32gather_pd(_mm512_extracti64x4_epi64(all, 1), pairs, 4);
  const __m512i evens = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
  return {(Floats)_mm512_permutex2var_ps(low, evens, high),
          (Floats)_mm512_permutex2var_ps(low, _mm512_add_epi32(evens, _mm512_set1_epi32(1)), high)};
#elif MOTES_WIDTH == 256
  const auto* const pairs = reinterpret_cast<const double*>(from);
  const __m256i all = (__m256i)at;
  const auto low = (__m256)_mm256_i32gather_pd(pairs, _mm256_castsi256_si128(all), 4);
  const auto high = (__m256)_mm256_i32gather_pd(pairs, _mm256_extracti128_si256(all, 1), 4);
  // Within halves of a register: 0 1 4 5 | 2 3 6 7, so quarters change places.
  const auto in_order = [](__m256 v) { return (Floats)_mm256_permute4x64_pd((__m256d)v, 0b11'01'10'00); };
  return {in_order(_mm256_shuffle_ps(low, high, 0b10'00'10'00)), in_order(_mm256_shuffle_ps(low, high, 0b11'01'11'01))};
#else
  return {gather(from, at), gather(from + 1, at)};
#endif
}

MOTES_INLINE Floats to_floats(Ints v) { return __builtin_convertvector(v, Floats); }
/// Rounds towards zero; the caller keeps lanes within the range of a 32-bit integer.
MOTES_INLINE Ints to_ints(Floats v) { return __builtin_convertvector(v, Ints); }
/// Rounds down; |v| < 2^24.
MOTES_INLINE Ints floor_to_ints(Floats v) {
#if MOTES_WIDTH == 512
  return (Ints)_mm512_cvt_roundps_epi32((__m512)v, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
#elif MOTES_WIDTH == 256
  return (Ints)_mm256_cvtps_epi32(_mm256_floor_ps((__m256)v));
#elif MOTES_NEON
  return (Ints)vcvtmq_s32_f32((float32x4_t)v);
#else
  const Ints towards_zero = to_ints(v);
  return towards_zero + (to_floats(towards_zero) > v);  // a true lane is -1
#endif
}
/// Rounds down where `sane`. Other lanes may have any value, and their results are undefined.
MOTES_INLINE Ints floor_where([[maybe_unused]] Mask sane, Floats v) {
#if MOTES_WIDTH >= 256 || MOTES_NEON
  return floor_to_ints(v);
#else
  return floor_to_ints(select(sane, v, Floats{}));
#endif
}

/// Returns the products of lanes that are below 2^15.
#if MOTES_WIDTH != 0
MOTES_INTEGERS(Uints, multiply_short, madd_epi16)
#else
MOTES_INLINE Uints multiply_short(Uints a, Uints b) { return a * b; }
#endif

}  // namespace motes::MOTES_ISA
