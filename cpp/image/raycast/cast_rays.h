// A vector of rays and their crossings with objects: see cast.h.
#pragma once

#include "image/raycast/cast.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

/// A vector of rays. Distances are in units of `along`.
struct Rays {
  Floats3 from, along;
};

MOTES_INLINE Floats3 at(const Rays& rays, Floats distance) { return rays.from + rays.along * distance; }

/// The crossings of rays with one object; only the lanes of `met` are valid.
struct RayHit {
  Mask met;
  Floats distance;
  Ints face;  // distinguishes faces that meet at an edge; of a mesh: the number of the triangle
};

MOTES_INLINE Floats3 operator-(Floats3 v) { return {-v.x, -v.y, -v.z}; }

/// Returns whether the distance is between `near` and `far`.
MOTES_INLINE Mask between(Floats distance, Floats near, Floats far) { return (distance > near) & (distance < far); }

/// Returns `v` or its opposite, whichever faces the ray's start.
MOTES_INLINE Floats3 towards(Floats3 v, const Rays& rays) { return select(dot(v, rays.along) > 0.0f, -v, v); }

MOTES_INLINE Floats3 unit(Floats3 v) { return v * (1.0f / sqrt(max(dot(v, v), all(1e-30f)))); }

/// Returns `v`, replaced by a small number where 1 / v would be infinite.
MOTES_INLINE Floats not_zero(Floats v) { return select(abs(v) < 1e-18f, all(1e-18f), v); }

/// Returns whether rays pass through a triangle. Two triangles that share an edge compute the same number for it, up to
/// the sign, and both own it, so no ray slips through between them.
MOTES_INLINE Mask pass_through(const float (*corner)[3], const Rays& rays) {
  const Floats3 a = all3(corner[0]) - rays.from, b = all3(corner[1]) - rays.from, c = all3(corner[2]) - rays.from;
  const Floats first = dot(rays.along, cross(c - b, c + b));
  const Floats second = dot(rays.along, cross(a - c, a + c));
  const Floats third = dot(rays.along, cross(b - a, b + a));
  return ((first >= 0.0f) & (second >= 0.0f) & (third >= 0.0f)) |
         ((first <= 0.0f) & (second <= 0.0f) & (third <= 0.0f));
}

}  // namespace motes::MOTES_ISA
