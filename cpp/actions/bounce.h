// bounce: particles whose path in this step meets the shape's surface leave it again.
//
// With n the normal at the true place of the hit, v splits into v_n along n and v_t along the surface:
//   v' = (1 - friction) v_t - restitution v_n        (no friction where |v_t| <= min_tangential_speed)
// The move that follows travels the whole step with v'. So that the particle is at the surface at the hit's time t,
// the position changes by (v - v') t: old speed before the hit, new speed after it. A skin of a few roundings keeps
// it on its side of the surface.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Floats skin_of(Floats3 p) {
  const Floats largest = max(max(abs(p.x), abs(p.y)), max(abs(p.z), all(1e-3f)));
  return largest * 0x1p-20f;
}

inline void bounce(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const float restitution = number(p, 0);
  const float slide = 1.0f - number(p, 1);
  const float cutoff2 = number(p, 2) * number(p, 2);
  visit(*p.shape, [&](const auto& shape) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      const Floats3 x = load3(b, kPositionAt, i);
      const Floats3 v = load3(b, kVelocityAt, i);
      const Hit hit = shape.hit(x, v * all(s.dt));
      if (!any(hit.mask)) continue;  // the common case: nothing to store
      const Floats3 normal_part = hit.normal * dot(v, hit.normal);
      const Floats3 tangential = v - normal_part;
      const Mask slides = dot(tangential, tangential) <= cutoff2;
      const Floats3 after = tangential * select(slides, all(1.0f), all(slide)) - normal_part * all(restitution);
      const Floats3 shifted = x + (v - after) * (hit.part * s.dt) + hit.normal * skin_of(x);
      store3(b, kVelocityAt, i, select(hit.mask, after, v));
      store3(b, kPositionAt, i, select(hit.mask, shifted, x));
    }
  });
}

}  // namespace motes::MOTES_ISA
