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

MOTES_INLINE Floats largest(Floats3 p) { return max(max(abs(p.x), abs(p.y)), abs(p.z)); }

MOTES_INLINE Floats skin_of(Floats3 start, Floats3 end) {
  return max(max(largest(start), largest(end)), all(1e-3f)) * 0x1p-20f;
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

/// Hits in one step that are followed, in corners and inside round walls; whoever meets more stops at the last.
inline constexpr int kMostHits = 8;

/// Positions and velocities from which the move ends where the path does that begins with `hit`.
template <class Shape>
MOTES_INLINE void follow(const Shape& shape, const Rebound& rebound, float dt, Hit hit, Floats3& x, Floats3& v) {
  Floats passed{}, rest = all(dt);  // seconds of the step before the last hit, and behind it
  Floats3 from = x, path = v * rest;
  for (int hits = 1;; ++hits) {
    const Floats3 after = rebound(v, hit.normal);
    const Floats3 met = from + path * hit.part;
    const Floats3 skin = hit.normal * skin_of(from, met);
    passed = select(hit.mask, passed + hit.part * rest, passed);
    x = select(hit.mask, x + (v - after) * passed + skin, x);
    v = select(hit.mask, after, v);
    if (requires { Shape::kFlat; }) return;  // a straight path leaves it for good
    from = met + skin;
    if (hits == kMostHits) {
      x = select(hit.mask, from - v * all(dt), x);
      return;
    }
    rest = dt - passed;
    path = (x + v * all(dt)) - from;  // to where the move will take it
    const Mask before = hit.mask;
    hit = shape.hit(from, path);
    hit.mask &= before;
    if (!any(hit.mask)) return;
  }
}

inline void bounce(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const Rebound rebound{number(p, 0), 1.0f - number(p, 1), number(p, 2) * number(p, 2)};
  visit(*p.shape, [&](const auto& shape) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      Floats3 x = load3(b, kPositionAt, i);
      Floats3 v = load3(b, kVelocityAt, i);
      const Hit hit = shape.hit(x, v * all(s.dt));
      if (!any(hit.mask)) continue;  // the common case: nothing to store
      follow(shape, rebound, s.dt, hit, x, v);
      store3(b, kPositionAt, i, x);
      store3(b, kVelocityAt, i, v);
      if (b.hit != nullptr) store_mask(b.hit + i, load_mask(b.hit + i) | hit.mask);
    }
  });
}

}  // namespace motes::MOTES_ISA
