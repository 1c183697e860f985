// Vectors of three numbers in double precision, for half the lanes: for places whose side of a surface must not depend
// on rounding.
#pragma once

#include "simd/doubles.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

struct Doubles3 {
  Doubles x, y, z;
};

MOTES_INLINE Doubles3 operator+(Doubles3 a, Doubles3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
MOTES_INLINE Doubles3 operator-(Doubles3 a, Doubles3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
MOTES_INLINE Doubles3 operator*(Doubles3 a, Doubles s) { return {a.x * s, a.y * s, a.z * s}; }
MOTES_INLINE Doubles dot(Doubles3 a, Doubles3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
MOTES_INLINE Doubles3 select(Longs mask, Doubles3 yes, Doubles3 no) {
  return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}
MOTES_INLINE Doubles min(Doubles a, Doubles b) { return select((Longs)(a < b), a, b); }
MOTES_INLINE Doubles max(Doubles a, Doubles b) { return select((Longs)(a > b), a, b); }
MOTES_INLINE Doubles largest(Doubles3 p) { return max(max(abs(p.x), abs(p.y)), abs(p.z)); }
MOTES_INLINE bool any(Longs mask) {
#if MOTES_WIDTH == 512
  return _mm512_movepi64_mask((__m512i)mask) != 0;
#elif MOTES_WIDTH == 256
  return _mm256_movemask_pd((__m256d)mask) != 0;
#elif MOTES_WIDTH == 128
  return _mm_movemask_pd((__m128d)mask) != 0;
#elif MOTES_NEON
  return vmaxvq_u32((uint32x4_t)mask) != 0;
#else
  std::int64_t bits = 0;
  for (std::size_t i = 0; i < kHalf; ++i) bits |= mask[i];
  return bits != 0;
#endif
}

/// Rounds to the nearest numbers of single precision.
MOTES_INLINE Doubles rounded(Doubles v) {
  using Singles = float __attribute__((vector_size(2 * MOTES_LANES)));
  return __builtin_convertvector(__builtin_convertvector(v, Singles), Doubles);
}
MOTES_INLINE Doubles3 rounded(Doubles3 v) { return {rounded(v.x), rounded(v.y), rounded(v.z)}; }

MOTES_INLINE Doubles3 low_half(Floats3 v) { return {low_half(v.x), low_half(v.y), low_half(v.z)}; }
MOTES_INLINE Doubles3 high_half(Floats3 v) { return {high_half(v.x), high_half(v.y), high_half(v.z)}; }
MOTES_INLINE Floats3 join(Doubles3 low, Doubles3 high) {
  return {join(low.x, high.x), join(low.y, high.y), join(low.z, high.z)};
}

/// Convert masks, by way of 1 and 0.
MOTES_INLINE Longs low_half(Mask mask) { return (Longs)(low_half(only(mask, all(1.0f))) != 0.0); }
MOTES_INLINE Longs high_half(Mask mask) { return (Longs)(high_half(only(mask, all(1.0f))) != 0.0); }
MOTES_INLINE Mask join(Longs low, Longs high) {
  const Doubles one = all_doubles(1.0);
  return join((Doubles)((Longs)one & low), (Doubles)((Longs)one & high)) != 0.0f;
}

/// One vector of three numbers, for values computed once per call.
struct Double3 {
  double x, y, z;
};
MOTES_INLINE Double3 doubles_of(const float* v) { return {v[0], v[1], v[2]}; }
MOTES_INLINE Double3 operator+(Double3 a, Double3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
MOTES_INLINE Double3 operator-(Double3 a, Double3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
MOTES_INLINE Double3 operator*(Double3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }
MOTES_INLINE double dot(Double3 a, Double3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
MOTES_INLINE Double3 cross(Double3 a, Double3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
MOTES_INLINE double length(Double3 a) { return __builtin_sqrt(dot(a, a)); }
MOTES_INLINE Double3 unit(Double3 a) { return a * (1.0 / length(a)); }
MOTES_INLINE Doubles3 all3(Double3 v) { return {all_doubles(v.x), all_doubles(v.y), all_doubles(v.z)}; }

}  // namespace motes::MOTES_ISA
