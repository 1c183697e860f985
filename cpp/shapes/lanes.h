// What every shape can do, a vector of particles at a time. One shape a file; this one holds the words they share.
#pragma once

#include "particles/random.h"
#include "shapes/shape.h"
#include "simd/elementary.h"
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
MOTES_INLINE Floats3 select(Mask mask, Floats3 yes, Floats3 no) {
  return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}
MOTES_INLINE Floats3 all3(const float* v) { return {all(v[0]), all(v[1]), all(v[2])}; }

/// One vector of three numbers, for what is computed once a block.
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
MOTES_INLINE Floats3 all3(Float3 v) { return {all(v.x), all(v.y), all(v.z)}; }

/// Where a path meets a surface: lanes that do, the part (0..1) of the path before it, the unit normal that looks
/// back along the path.
struct Hit {
  Mask mask;
  Floats part;
  Floats3 normal;
};

MOTES_INLINE Hit no_hit() { return {Mask{}, Floats{}, {Floats{}, Floats{}, Floats{}}}; }

}  // namespace motes::MOTES_ISA
