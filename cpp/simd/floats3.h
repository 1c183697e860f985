// Vectors of three numbers: Floats3 holds one per lane, Float3 a single one.
#pragma once

#include "simd/simd.h"

namespace motes::MOTES_ISA {

struct Floats3 {
  Floats x, y, z;
};

MOTES_INLINE Floats3 operator+(Floats3 a, Floats3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
MOTES_INLINE Floats3 operator-(Floats3 a, Floats3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
MOTES_INLINE Floats3 operator*(Floats3 a, Floats s) { return {a.x * s, a.y * s, a.z * s}; }
MOTES_INLINE Floats3 operator*(Floats3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
MOTES_INLINE Floats dot(Floats3 a, Floats3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
MOTES_INLINE Floats3 cross(Floats3 a, Floats3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
MOTES_INLINE Floats3 select(Mask mask, Floats3 yes, Floats3 no) {
  return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}
MOTES_INLINE Floats3 only(Mask mask, Floats3 v) { return {only(mask, v.x), only(mask, v.y), only(mask, v.z)}; }
/// Returns the largest magnitude of the three numbers.
MOTES_INLINE Floats largest(Floats3 v) { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }
/// Tells where all three numbers are finite, with a sum of magnitudes within the range of float32.
MOTES_INLINE Mask finite(Floats3 v) { return abs(v.x) + abs(v.y) + abs(v.z) <= __FLT_MAX__; }
MOTES_INLINE bool all_finite(Floats3 v) { return all_at_most(abs(v.x) + abs(v.y) + abs(v.z), __FLT_MAX__); }
MOTES_INLINE Floats3 all3(const float* v) { return {all(v[0]), all(v[1]), all(v[2])}; }

/// Returns the largest power of two up to a normal positive number: to scale by it is exact.
MOTES_INLINE float power_of_two(float x) {
  return __builtin_bit_cast(float, __builtin_bit_cast(std::uint32_t, x) & 0x7f800000u);
}

/// One vector of three numbers, for values computed once per block.
struct Float3 {
  float x, y, z;
};
MOTES_INLINE Float3 of(const float* v) { return {v[0], v[1], v[2]}; }
MOTES_INLINE Float3 minus(Float3 a, Float3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
MOTES_INLINE Float3 times(Float3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
MOTES_INLINE float dot(Float3 a, Float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
MOTES_INLINE Float3 cross(Float3 a, Float3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
MOTES_INLINE Float3 unit(Float3 a) { return times(a, 1.0f / __builtin_sqrtf(dot(a, a))); }

/// Two unit vectors that are perpendicular to the unit vector `normal` and to each other.
struct Basis {
  Float3 u, v;
};
MOTES_INLINE Basis basis_of(Float3 normal) {
  // Any axis that is not nearly parallel to the normal will do.
  const Float3 axis = normal.x * normal.x < 0.5f ? Float3{1, 0, 0} : Float3{0, 1, 0};
  const Float3 u = unit(cross(normal, axis));
  return {u, cross(normal, u)};
}

/// Sets one lane.
MOTES_INLINE void set_lane(Floats3& v, std::size_t lane, Float3 to) {
  v.x[lane] = to.x;
  v.y[lane] = to.y;
  v.z[lane] = to.z;
}

MOTES_INLINE Floats3 all3(Float3 v) { return {all(v.x), all(v.y), all(v.z)}; }

}  // namespace motes::MOTES_ISA
