// Half the lanes in double precision: for steps of a computation where 24 bits are not enough.
#pragma once

#include "simd/simd.h"

namespace motes::MOTES_ISA {

/// Half as many lanes as Floats has.
using Doubles = double __attribute__((vector_size(4 * MOTES_LANES)));
using Longs = std::int64_t __attribute__((vector_size(4 * MOTES_LANES)));

inline constexpr std::size_t kHalf = MOTES_LANES / 2;

MOTES_INLINE Doubles low_half(Floats v) {
#if MOTES_WIDTH == 512
  return (Doubles)_mm512_cvtps_pd(_mm512_castps512_ps256((__m512)v));
#elif MOTES_WIDTH == 256
  return (Doubles)_mm256_cvtps_pd(_mm256_castps256_ps128((__m256)v));
#elif MOTES_WIDTH == 128
  return (Doubles)_mm_cvtps_pd((__m128)v);
#elif MOTES_NEON
  return (Doubles)vcvt_f64_f32(vget_low_f32((float32x4_t)v));
#else
  Doubles d;
  for (std::size_t i = 0; i < kHalf; ++i) d[i] = v[i];
  return d;
#endif
}

MOTES_INLINE Doubles high_half(Floats v) {
#if MOTES_WIDTH == 512
  return (Doubles)_mm512_cvtps_pd(_mm512_extractf32x8_ps((__m512)v, 1));
#elif MOTES_WIDTH == 256
  return (Doubles)_mm256_cvtps_pd(_mm256_extractf128_ps((__m256)v, 1));
#elif MOTES_WIDTH == 128
  return (Doubles)_mm_cvtps_pd(_mm_movehl_ps((__m128)v, (__m128)v));
#elif MOTES_NEON
  return (Doubles)vcvt_high_f64_f32((float32x4_t)v);
#else
  Doubles d;
  for (std::size_t i = 0; i < kHalf; ++i) d[i] = v[kHalf + i];
  return d;
#endif
}

/// Joins two halves, rounded to nearest.
MOTES_INLINE Floats join(Doubles low, Doubles high) {
#if MOTES_WIDTH == 512
  const __m512 first = _mm512_castps256_ps512(_mm512_cvtpd_ps((__m512d)low));
  return (Floats)_mm512_insertf32x8(first, _mm512_cvtpd_ps((__m512d)high), 1);
#elif MOTES_WIDTH == 256
  return (Floats)_mm256_set_m128(_mm256_cvtpd_ps((__m256d)high), _mm256_cvtpd_ps((__m256d)low));
#elif MOTES_WIDTH == 128
  return (Floats)_mm_movelh_ps(_mm_cvtpd_ps((__m128d)low), _mm_cvtpd_ps((__m128d)high));
#elif MOTES_NEON
  return (Floats)vcvt_high_f32_f64(vcvt_f32_f64((float64x2_t)low), (float64x2_t)high);
#else
  Floats v;
  for (std::size_t i = 0; i < kHalf; ++i) {
    v[i] = static_cast<float>(low[i]);
    v[kHalf + i] = static_cast<float>(high[i]);
  }
  return v;
#endif
}

MOTES_INLINE Doubles all_doubles(double value) {
  Doubles v;
  for (std::size_t i = 0; i < kHalf; ++i) v[i] = value;
  return v;
}

MOTES_INLINE Doubles select(Longs mask, Doubles yes, Doubles no) {
  return (Doubles)(((Longs)yes & mask) | ((Longs)no & ~mask));
}

MOTES_INLINE Doubles abs(Doubles v) { return (Doubles)((Longs)v & 0x7fffffffffffffff); }

MOTES_INLINE Doubles sqrt(Doubles v) {
#if MOTES_WIDTH == 512
  return (Doubles)_mm512_sqrt_pd((__m512d)v);
#elif MOTES_WIDTH == 256
  return (Doubles)_mm256_sqrt_pd((__m256d)v);
#elif MOTES_WIDTH == 128
  return (Doubles)_mm_sqrt_pd((__m128d)v);
#elif MOTES_NEON
  return (Doubles)vsqrtq_f64((float64x2_t)v);
#else
  for (std::size_t i = 0; i < kHalf; ++i) v[i] = __builtin_sqrt(v[i]);
  return v;
#endif
}

/// Adding this number to v and subtracting it again rounds to the nearest integer, for |v| < 2^51.
inline constexpr double kWhole = 0x1.8p52;
MOTES_INLINE Doubles round(Doubles v) { return (v + kWhole) - kWhole; }

}  // namespace motes::MOTES_ISA
