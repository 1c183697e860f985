// bounce: particles whose path in this step meets the shape's surface leave it again.
//
// With n the normal at the true place of the hit, v splits into v_n along n and v_t along the surface:
//   v' = (1 - friction) v_t - restitution v_n        (no friction where |v_t| <= min_tangential_speed)
// The rest of the step goes on from there with v', and may hit again: an edge, a corner, the inside of a ball. The
// move that follows travels the whole step with the last speed, so the position changes to where that move must start
// from. A skin of a few roundings keeps the particle on its side of the surface.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Floats skin_of(Floats3 p) {
  const Floats largest = max(max(abs(p.x), abs(p.y)), max(abs(p.z), all(1e-3f)));
  return largest * 0x1p-20f;
}

struct Rebound {
  float restitution, slide, cutoff2;

  MOTES_INLINE Floats3 operator()(Floats3 v, Floats3 normal) const {
    const Floats3 across = normal * dot(v, normal);
    const Floats3 along = v - across;
    const Mask free = dot(along, along) <= cutoff2;
    return along * select(free, all(1.0f), all(slide)) - across * restitution;
  }
};

/// Hits in one step that are followed; whoever meets more stops at the last.
inline constexpr int kMostHits = 8;

/// What a step leaves of a vector of particles that met the shape.
struct Bounced {
  Floats3 x, v;
  Mask mask;
};

/// A particle meets a solid once more in the same step where it is inside, in a corner or very fast.
inline constexpr int kMostBounces = 4;

template <class Shape>
MOTES_INLINE Bounced bounce_vector(const Shape& shape, const actions::Parameters& p, float dt, Floats3 x, Floats3 v,
                                   Hit hit) {
  const float restitution = number(p, 0);
  const float slide = 1.0f - number(p, 1);
  const float cutoff2 = number(p, 2) * number(p, 2);
  const Mask mask = hit.mask;
  Floats passed{}, rest = all(dt);  // seconds of the step before the last hit, and behind it
  for (int bounces = 1;; ++bounces) {
    const Floats3 normal_part = hit.normal * dot(v, hit.normal);
    const Floats3 tangential = v - normal_part;
    const Mask slides = dot(tangential, tangential) <= cutoff2;
    const Floats3 after = tangential * select(slides, all(1.0f), all(slide)) - normal_part * all(restitution);
    passed = select(hit.mask, passed + hit.part * rest, passed);
    x = select(hit.mask, x + (v - after) * passed + hit.normal * skin_of(x), x);
    v = select(hit.mask, after, v);
    // A straight path leaves a flat shape for good.
    if (requires { Shape::kFlat; } || bounces == kMostBounces) break;
    rest = dt - passed;
    const Floats3 at = x + v * passed;
    const Mask before = hit.mask;
    hit = shape.hit(at, (x + v * all(dt)) - at);  // to where the move will take it
    hit.mask &= before;
    if (!any(hit.mask)) break;
  }
  return {x, v, mask};
}

inline void bounce(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  visit(*p.shape, [&](const auto& shape) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      const Floats3 x = load3(b, kPositionAt, i);
      const Floats3 v = load3(b, kVelocityAt, i);
      const Hit hit = shape.hit(x, v * all(s.dt));
      if (!any(hit.mask)) continue;  // the common case: nothing to store
      const Bounced after = bounce_vector(shape, p, s.dt, x, v, hit);
      store3(b, kVelocityAt, i, after.v);
      store3(b, kPositionAt, i, after.x);
      if (b.hit != nullptr) store_mask(b.hit + i, load_mask(b.hit + i) | after.mask);
    }
  });
}

}  // namespace motes::MOTES_ISA
