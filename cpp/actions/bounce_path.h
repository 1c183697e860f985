// bounce: the paths of the few particles that may meet a surface in this step, in double precision.
//
// What holds after each hit, and so at the end: the particle is at a place of single precision that it reached on
// straight ways which meet no surface, as judged by meet() alone. The move that follows is part of that: its end is
// computed here with move's own arithmetic, x + v dt in single precision, and the way there is judged, too. Since the
// side of a place is a function of the place (shapes/exact.h), the next step sees the particle on the side where this
// one left it.
//
// A hit is computed exactly, but its place is rounded to single precision: by half of 2^-23 of the largest coordinate,
// and again where the move starts, by that part of the way that it goes. So the particle is put 2^-20 of its
// coordinates and 2^-22 of its way off the surface, as a start: if it then is not on its side, an eighth of that, and
// if not there either, because the shape is smaller than rounding or another wall is near, where it last was.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

struct Rebound {
  float restitution, slide, cutoff2;

  /// The part of the speed along the surface that remains, by its square.
  MOTES_INLINE Floats kept(Floats along2) const { return select(along2 <= cutoff2, all(1.0f), all(slide)); }
  MOTES_INLINE Floats3 operator()(Floats3 v, Floats3 normal) const {
    const Floats3 across = normal * dot(v, normal);
    const Floats3 along = v - across;
    return along * kept(dot(along, along)) - across * restitution;
  }
  /// In double precision; what already goes away from the surface goes on.
  MOTES_INLINE Doubles3 operator()(Doubles3 v, Doubles3 normal) const {
    const Doubles speed = dot(v, normal);
    const Doubles3 across = normal * speed, along = v - across;
    const Doubles kept = select((Longs)(dot(along, along) <= cutoff2), all_doubles(1.0), all_doubles(slide));
    return select((Longs)(speed < 0.0), rounded(along * kept - across * all_doubles(restitution)), v);
  }
};

/// The most hits per step that are followed, in corners and inside round walls; a particle with more stops at the last.
inline constexpr int kMostHits = 8;

/// Where move takes particles, to the last bit.
MOTES_INLINE Doubles3 moved(Doubles3 x, Doubles3 v, Doubles dt) { return rounded(x + rounded(v * dt)); }

/// A place at the surface that is hit on the way from one place to another, on the side of the first.
MOTES_INLINE Doubles3 place_of(const shapes::Shape& shape, const Met& hit, Doubles3 from, Doubles3 to, Doubles farthest,
                               Longs among) {
  const Doubles3 at = from + (to - from) * hit.part;
  const Doubles size = max(max(max(largest(from), largest(at)), farthest * 0.25), all_doubles(1e-3));
  Doubles3 place = from;
  double skin = 0x1p-20;
  for (int tries = 0; tries < 2 && any(among); ++tries, skin *= 0.125) {
    const Doubles3 tried = rounded(at + hit.normal * (size * skin));
    const Longs good = among & ~meet(shape, from, tried).mask;
    place = select(good, tried, place);
    among &= ~good;
  }
  return place;
}

/// Sets positions and velocities of the lanes of `going` so that the move ends where their paths end; returns which of
/// them bounced.
__attribute__((noinline)) inline Longs follow(const shapes::Shape& shape, const Rebound& rebound, float step,
                                              Longs going, Doubles3& x, Doubles3& v) {
  const Doubles dt = all_doubles(step);
  Doubles passed{};  // seconds of the step before the last hit
  Doubles3 from = x;
  Longs bounced{};
  for (int hits = 0;; ++hits) {
    const Doubles3 to = moved(x, v, dt);
    const Met hit = meet(shape, from, to);
    going &= hit.mask;
    if (!any(going)) return bounced;
    if (hits == kMostHits) break;
    bounced |= going;
    from = select(going, place_of(shape, hit, from, to, largest(v) * dt, going), from);
    passed = select(going, passed + hit.part * (dt - passed), passed);
    v = select(going, rebound(v, hit.normal), v);
    const bool last = hits == kMostHits - 1;
    x = select(going, rounded(from - v * (last ? dt : passed)), x);
  }
  // Not even that can be rounded so that it stays on its side.
  x = select(going, from, x);
  v = select(going, Doubles3{}, v);
  return bounced;
}

/// Sets velocities of the lanes of `going` so that the move does not meet the shape; returns which of them bounced.
__attribute__((noinline)) inline Longs turn(const shapes::Shape& shape, const Rebound& rebound, float step, Longs going,
                                            const Doubles3& x, Doubles3& v) {
  Longs bounced{};
  for (int hits = 0;; ++hits) {
    const Met hit = meet_by_ends(shape, x, moved(x, v, all_doubles(step)));
    going &= hit.mask;
    if (!any(going)) return bounced;
    bounced |= going;
    const bool last = hits == kMostHits;
    v = select(going, last ? Doubles3{} : rebound(v, hit.normal), v);
    if (last) return bounced;
  }
}

/// Calls use(lanes, x, v), which changes x and v and returns which lanes it changed, for both halves of a vector where
/// `among` has lanes; returns what these calls return.
template <class Use>
MOTES_INLINE Mask by_halves(Mask among, Floats3& x, Floats3& v, const Use& use) {
  const Longs lower = low_half(among), upper = high_half(among);
  Doubles3 low_x = low_half(x), low_v = low_half(v), high_x = high_half(x), high_v = high_half(v);
  const Longs low = any(lower) ? use(lower, low_x, low_v) : Longs{};
  const Longs high = any(upper) ? use(upper, high_x, high_v) : Longs{};
  const Mask changed = join(low, high);
  x = select(changed, join(low_x, high_x), x);
  v = select(changed, join(low_v, high_v), v);
  return changed;
}

}  // namespace motes::MOTES_ISA
