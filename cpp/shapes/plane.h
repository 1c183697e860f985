// The plane through a point, with a normal: contains the half-space below it. A sample is always the point itself,
// since no distribution is uniform over an infinite plane.
#pragma once

#include "shapes/lanes.h"

namespace motes::MOTES_ISA {

struct ExactPlane;  // in exact_flat.h

/// The side of a plane that places are on; if neither is true, rounding decides.
struct Sides {
  Mask above, below;
};

struct PlaneLanes {
  using Exact = ExactPlane;
  const shapes::Shape* shape;
  Float3 point, normal;

  static MOTES_INLINE PlaneLanes from(const shapes::Shape& s) {
    const auto plane = s.as<shapes::numbers::plane>();
    return {&s, of(plane.point), unit(of(plane.normal))};
  }
  MOTES_INLINE Floats height(Floats3 p) const { return dot(p - all3(point), all3(normal)); }
  MOTES_INLINE Mask contains(Floats3 p) const {
    const Sides at = sides(p);
    return any(~(at.above | at.below)) ? contains_exactly(*shape, p) : at.below;
  }
  MOTES_INLINE Floats3 sample(Draws&) const { return all3(point); }

  MOTES_INLINE Sides sides(Floats3 p) const {
    const Floats3 d = p - all3(point);
    const Floats x = d.x * normal.x, y = d.y * normal.y, z = d.z * normal.z;
    const Floats height = x + y + z, rounding = (abs(x) + abs(y) + abs(z)) * kRounding;
    return {height > rounding, height < -rounding};
  }
  /// Returns false where a path ends above.
  MOTES_INLINE Mask may_meet(Floats3, Floats3 to) const { return ~sides(to).above; }
  /// Returns false where a path stays on one side.
  MOTES_INLINE Mask may_pass(Floats3 p, Floats3 to) const {
    const Sides before = sides(p), after = sides(to);
    return ~((before.above & after.above) | (before.below & after.below));
  }

  /// Returns where paths meet the plane. One-sided: every downward path that would end below the plane meets it, at
  /// once if it starts below.
  MOTES_INLINE Hit hit(Floats3 p, Floats3 path) const {
    const Floats before = height(p);
    const Floats change = dot(path, all3(normal));
    const Mask mask = (before + change < 0.0f) & (change < 0.0f);
    const Floats part = max(before / -change, Floats{});
    return {mask, select(mask, min(part, all(1.0f)), Floats{}), all3(normal)};
  }
};

/// Bounds of a flat piece of a plane, to exclude paths that stay clear of it.
struct Surroundings {
  float reach2;    // squared distance from its first corner, or its centre, to its farthest point
  float rounding;  // error of a height, relative to the distance from that point; larger for a sliver, whose normal is
                   // uncertain

  static MOTES_INLINE Surroundings of_edges(Float3 u, Float3 v) {
    const Float3 across = cross(u, v);
    const float u2 = dot(u, u), v2 = dot(v, v);
    const float blunt = __builtin_sqrtf(u2) * __builtin_sqrtf(v2) / __builtin_sqrtf(dot(across, across));
    return {2.0f * (u2 + v2), kRounding * (1.0f + blunt)};
  }
  /// Returns false where a path stays on one side of the plane or far from the piece.
  MOTES_INLINE Mask may_meet(Float3 point, Float3 normal, Floats3 p, Floats3 to) const {
    const auto sides = [&](Floats3 q) __attribute__((always_inline)) {
      const Floats3 d = q - all3(point);
      const Floats height = dot(d, all3(normal)), err = (abs(d.x) + abs(d.y) + abs(d.z)) * rounding;
      return Sides{height > err, height < -err};
    };
    const Sides before = sides(p), after = sides(to);
    const Floats3 d = p - all3(point), way = to - p;
    const Mask far = dot(d, d) > (dot(way, way) + reach2) * 2.001f;  // more than (|way| + reach)^2
    return ~((before.above & after.above) | (before.below & after.below) | far);
  }
};

/// Where a path crosses the plane of a flat shape, from either side.
struct PlaneCrossing {
  Mask mask;
  Floats part;
  Floats3 at, normal;
};

MOTES_INLINE PlaneCrossing cross_plane(Float3 point, Float3 normal, Floats3 p, Floats3 path) {
  const Floats before = dot(p - all3(point), all3(normal));
  const Floats change = dot(path, all3(normal));
  // The side that the next step will compute, to the last bit: before + change may give the other side.
  const Floats after = dot((p + path) - all3(point), all3(normal));
  const Mask mask = ((before > 0.0f) & (after <= 0.0f)) | ((before < 0.0f) & (after >= 0.0f));
  const Floats part = select(mask & (change != 0.0f), min(max(before / -change, Floats{}), all(1.0f)), Floats{});
  const Floats side = select(before > 0.0f, all(1.0f), all(-1.0f));
  return {mask, part, p + path * part, all3(normal) * side};
}

}  // namespace motes::MOTES_ISA
