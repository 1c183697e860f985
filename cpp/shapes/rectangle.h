// The parallelogram origin + a u + b v, a and b in 0..1.
#pragma once

#include "shapes/plane.h"

namespace motes::MOTES_ISA {

struct ExactRectangle;  // in exact_flat.h

struct RectangleLanes {
  static constexpr bool kDrawsTogether = true;
  using Exact = ExactRectangle;
  Float3 origin, u, v, normal;

  static MOTES_INLINE RectangleLanes from(const shapes::Shape& s) {
    const auto rectangle = s.as<shapes::numbers::rectangle>();
    const Float3 u = of(rectangle.u), v = of(rectangle.v);
    return {of(rectangle.origin), u, v, unit(cross(u, v))};
  }
  MOTES_INLINE Mask contains(Floats3) const { return Mask{}; }
  MOTES_INLINE Floats3 sample(Draws& draws) const {
    const Uints4 bits = draws.bits();
    return all3(origin) + all3(u) * unit(bits.a) + all3(v) * unit(bits.b);
  }
  MOTES_INLINE Mask may_meet(Floats3 p, Floats3 to) const {
    return Surroundings::of_edges(u, v).may_meet(origin, normal, p, to);
  }
  MOTES_INLINE Hit hit(Floats3 p, Floats3 path) const {
    const PlaneCrossing c = cross_plane(origin, normal, p, path);
    // a and b solve at = origin + a u + b v, by the edges' reciprocal vectors.
    const Float3 uxv = cross(u, v);
    const float scale = 1.0f / dot(uxv, uxv);
    const Floats3 from_origin = c.at - all3(origin);
    const Floats a = dot(from_origin, all3(times(cross(v, uxv), scale)));
    const Floats b = dot(from_origin, all3(times(cross(uxv, u), scale)));
    const Mask within = (a >= 0.0f) & (a <= 1.0f) & (b >= 0.0f) & (b <= 1.0f);
    return {c.mask & within, c.part, c.normal};
  }
};

}  // namespace motes::MOTES_ISA
