// The triangle between three points.
#pragma once

#include "shapes/plane.h"

namespace motes::MOTES_ISA {

struct ExactTriangle;  // in exact_flat.h

struct TriangleLanes {
  using Exact = ExactTriangle;
  Float3 origin, u, v, normal;
  Float3 to_a, to_b;  // reciprocal vectors of the edges: a point is origin + a u + b v

  static MOTES_INLINE TriangleLanes from(const shapes::Shape& s) {
    const auto triangle = s.as<shapes::numbers::triangle>();
    const Float3 origin = of(triangle.p0);
    const Float3 u = minus(of(triangle.p1), origin);
    const Float3 v = minus(of(triangle.p2), origin);
    const Float3 uxv = cross(u, v);
    const float scale = 1.0f / dot(uxv, uxv);
    return {origin, u, v, unit(uxv), times(cross(v, uxv), scale), times(cross(uxv, u), scale)};
  }
  MOTES_INLINE Mask contains(Floats3) const { return Mask{}; }
  MOTES_INLINE Floats3 sample(Draws& draws) const {
    const Uints4 bits = draws.bits();
    // Uniform by area: the far half of the parallelogram is folded onto the near one.
    Floats a = unit(bits.a), b = unit(bits.b);
    const Mask far = a + b > 1.0f;
    a = select(far, 1.0f - a, a);
    b = select(far, 1.0f - b, b);
    return all3(origin) + all3(u) * a + all3(v) * b;
  }
  MOTES_INLINE Mask may_meet(Floats3 p, Floats3 to) const {
    return Surroundings::of_edges(u, v).may_meet(origin, normal, p, to);
  }
  MOTES_INLINE Hit hit(Floats3 p, Floats3 path) const {
    const PlaneCrossing c = cross_plane(origin, normal, p, path);
    const Floats3 from_origin = c.at - all3(origin);
    const Floats a = dot(from_origin, all3(to_a));
    const Floats b = dot(from_origin, all3(to_b));
    constexpr float kSeam = 1e-6f;  // triangles that share an edge leave no gap between them
    const Mask within = (a >= -kSeam) & (b >= -kSeam) & (a + b <= 1.0f + kSeam);
    return {c.mask & within, c.part, c.normal};
  }
};

}  // namespace motes::MOTES_ISA
