// A flat ring: the points of a plane between two distances from a centre.
#pragma once

#include "shapes/plane.h"

namespace motes::MOTES_ISA {

struct ExactDisc;  // in exact_flat.h

struct DiscLanes {
  static constexpr bool kDrawsTogether = true;
  using Exact = ExactDisc;
  Float3 center, normal, u, v;
  float radius, inner;

  static MOTES_INLINE DiscLanes from(const shapes::Shape& s) {
    const auto disc = s.as<shapes::numbers::disc>();
    const Float3 n = unit(of(disc.normal));
    const Basis basis = basis_of(n);
    return {of(disc.center), n, basis.u, basis.v, disc.radius, disc.inner_radius};
  }
  MOTES_INLINE Mask contains(Floats3) const { return Mask{}; }
  MOTES_INLINE Floats3 sample(Draws& draws) const {
    const Uints4 bits = draws.bits();
    Floats cosine, sine;
    cos_sin_turn(unit(bits.a), cosine, sine);
    // Uniform by area: the squared distance is uniform.
    const float inner2 = inner * inner;
    const Floats r = sqrt(all(inner2) + unit(bits.b) * (radius * radius - inner2));
    return all3(center) + all3(u) * (r * cosine) + all3(v) * (r * sine);
  }
  MOTES_INLINE Mask may_meet(Floats3 p, Floats3 to) const {
    return Surroundings{radius * radius, 2.0f * kRounding}.may_meet(center, normal, p, to);
  }
  MOTES_INLINE Hit hit(Floats3 p, Floats3 path) const {
    const PlaneCrossing c = cross_plane(center, normal, p, path);
    const Floats3 from_center = c.at - all3(center);
    const Floats distance2 = dot(from_center, from_center);
    const Mask within = (distance2 <= radius * radius) & (distance2 >= inner * inner);
    return {c.mask & within, c.part, c.normal};
  }
};

}  // namespace motes::MOTES_ISA
