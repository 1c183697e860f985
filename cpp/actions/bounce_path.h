// bounce: the paths of the few particles that may meet a surface in this step, in double precision.
//
// Invariant after each hit: the particle is at a single-precision position that it reached along straight segments
// which, by meet() alone, meet no surface. This includes the move that follows: its end is computed here with move's
// own arithmetic, x + v dt in single precision, and its segment is tested too. Since the side of a point depends only
// on the point (shapes/exact.h), the next step finds the particle on the side where this step left it.
//
// Hits are computed exactly, but their positions are rounded to single precision: by half of 2^-23 of the largest
// coordinate, and again at the start of the move, by the same fraction of its length. Therefore a particle is placed
// off the surface by 2^-20 of its coordinates and 2^-22 of its path. If it is then not on its side, because the shape
// is smaller than rounding or another wall is near, an eighth of this distance is tried, and finally its last position.
#pragma once

#include "actions/hits.h"

namespace motes::MOTES_ISA {

struct Rebound {
  float restitution, slide, cutoff2;

  /// Returns the factor by which friction scales the velocity along the surface, given its square.
  MOTES_INLINE Floats kept(Floats along2) const { return select(along2 <= cutoff2, all(1.0f), all(slide)); }
  MOTES_INLINE Floats3 operator()(Floats3 v, Floats3 normal) const {
    const Floats3 across = normal * dot(v, normal);
    const Floats3 along = v - across;
    return along * kept(dot(along, along)) - across * restitution;
  }
  /// Reflects in double precision; velocities away from the surface do not change.
  MOTES_INLINE Doubles3 operator()(Doubles3 v, Doubles3 normal) const {
    const Doubles speed = dot(v, normal);
    const Doubles3 across = normal * speed, along = v - across;
    const Doubles kept = select((Longs)(dot(along, along) <= cutoff2), all_doubles(1.0), all_doubles(slide));
    return select((Longs)(speed < 0.0), rounded(along * kept - across * all_doubles(restitution)), v);
  }
};

/// The maximum number of hits per step, in corners and inside round walls; a particle with more stops at the last one.
inline constexpr int kMostHits = 8;

/// Returns where `move` takes particles, to the last bit.
MOTES_INLINE Doubles3 moved(Doubles3 x, Doubles3 v, Doubles dt) { return rounded(x + rounded(v * dt)); }

/// Returns a position at the surface that is hit between `from` and `to`, on the side of `from`; `from` itself if
/// rounding allows none.
MOTES_INLINE Doubles3 place_of(const shapes::Shape& shape, const Met& hit, Doubles3 from, Doubles3 to, Doubles farthest,
                               Longs among) {
  const Doubles3 at = from + (to - from) * hit.part;
  const Doubles size = max(max(largest(from), largest(at)), farthest * 0.25);
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

/// Sets positions and velocities of the lanes of `going` so that the move that follows ends where their paths end;
/// returns which of them bounced. Adds their hits to `seen`: HalfHits, or Unseen.
template <class Seen>
__attribute__((noinline)) Longs follow(const shapes::Shape& shape, const Rebound& rebound, float step, Longs going,
                                       Doubles3& x, Doubles3& v, Seen& seen) {
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
    seen.add(going, hit.normal, from);
    passed = select(going, passed + hit.part * (dt - passed), passed);
    v = select(going, rebound(v, hit.normal), v);
    const bool last = hits == kMostHits - 1;
    x = select(going, rounded(from - v * (last ? dt : passed)), x);
  }
  // Rounding does not allow even that: stop at the last position.
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

/// Calls use(lanes, x, v, half) for each half, 0 or 1, of a vector that has lanes in `among`. `use` changes x and v and
/// returns which lanes it changed; the result combines both halves.
template <class Use>
MOTES_INLINE Mask by_halves(Mask among, Floats3& x, Floats3& v, const Use& use) {
  const Longs lower = low_half(among), upper = high_half(among);
  Doubles3 low_x = low_half(x), low_v = low_half(v), high_x = high_half(x), high_v = high_half(v);
  const Longs low = any(lower) ? use(lower, low_x, low_v, 0) : Longs{};
  const Longs high = any(upper) ? use(upper, high_x, high_v, 1) : Longs{};
  const Mask changed = join(low, high);
  x = select(changed, join(low_x, high_x), x);
  v = select(changed, join(low_v, high_v), v);
  return changed;
}

}  // namespace motes::MOTES_ISA
