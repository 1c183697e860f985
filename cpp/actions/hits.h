// What bounces note of their hits in columns: how many in this frame, the normal of the last one, and where it was.
//
// rest: particles that have landed in this sub-step and are slow lie down: they are put at their landing, stop and stop
// turning, and turn the shortest way until their z axis or its opposite is within an angle of the normal.
//
// landing = x, y, z of the last hit and the stamp of its sub-step; stamp 0 if the surface moved there. `rest` puts
// particles at their landing: a place on their side of the surface, at most a skin (bounce_path.h) above it.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

/// The hits of a vector of particles in one bounce. `still`: the surface did not move at the last hit.
struct Hits {
  Floats count;
  Floats3 normal, place;
  Mask still;
};

/// The hits of half a vector of particles.
struct HalfHits {
  Doubles count{};
  Doubles3 normal{}, place{};

  MOTES_INLINE void add(Longs mask, Doubles3 its_normal, Doubles3 its_place) {
    count = count + select(mask, all_doubles(1.0), Doubles{});
    normal = select(mask, its_normal, normal);
    place = select(mask, its_place, place);
  }
};

/// For bounces that note no hits, whose code stays free of them.
struct Unseen {
  MOTES_INLINE void add(Longs, Doubles3, Doubles3) {}
};

MOTES_INLINE Hits join(const HalfHits& low, const HalfHits& high) {
  return {join(low.count, high.count), join(low.normal, high.normal), join(low.place, high.place), ~Mask{}};
}

/// Returns the number, other than 0, by which a sub-step is told from the others of its frame.
MOTES_INLINE float stamp_of(const actions::Step& s) { return static_cast<float>(1 + (s.step & 0xffffu)); }

/// A particle that has moved less than this part of its largest coordinate before its hit has landed where it started,
/// so that what rests stays in place to the last bit.
inline constexpr float kUnmoved = 0x1p-16f;

/// Adds hits to the columns of the lanes of `mask`. `start`: where the particles were before the step.
__attribute__((noinline)) inline void note_hits(const actions::Block& b, std::size_t i, const Mask& mask,
                                                const Hits& hits, const Floats3& start) {
  float* const count = b.component[kHitAt] + i;
  float* const stamp = b.component[kLandingAt + 3] + i;
  const Floats before = load(count);
  store(count, select(mask, before + hits.count, before));
  store3(b, kHitNormalAt, i, select(mask, hits.normal, load3(b, kHitNormalAt, i)));
  const Mask unmoved = largest(hits.place - start) <= largest(start) * kUnmoved;
  store3(b, kLandingAt, i, select(mask, select(unmoved, start, hits.place), load3(b, kLandingAt, i)));
  store(stamp, select(mask, only(hits.still, all(b.stamp)), load(stamp)));
}

/// Turns smaller than this, as the sine of half their angle, are left out, so that what lies keeps its bits.
inline constexpr float kLying = 0x1p-14f;

/// Makes the angle of rotations smaller by the angle whose half has this cosine and sine. Returns those that still
/// turn.
MOTES_INLINE Mask reduce(Rotations& turn, Floats cosine, Floats sine) {
  const Floats half_sine = sqrt(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z);
  const Floats left = half_sine * cosine - turn.w * sine;
  const Mask turns = left > kLying;
  const Floats scale = left / select(turns, half_sine, all(1.0f));
  turn = {turn.x * scale, turn.y * scale, turn.z * scale, turn.w * cosine + half_sine * sine};
  return turns;
}

inline void rest(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  constexpr float kHalfDegree = 0.0087266462599716477f;  // radians
  const auto n = numbers_of<numbers::rest>(p);
  Floats cosine, sine;
  cos_sin(all(n.angle_deg * kHalfDegree), cosine, sine);
  const float stamp = stamp_of(s);
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Mask landed = load(b.component[kLandingAt + 3] + i) == stamp;
    if (!any(landed)) continue;
    const Floats3 v = load3(b, kVelocityAt, i), normal = load3(b, kHitNormalAt, i);
    const Mask rests = landed & (dot(v, v) <= n.speed * n.speed);
    if (!any(rests)) continue;
    store3(b, kPositionAt, i, select(rests, load3(b, kLandingAt, i), load3(b, kPositionAt, i)));
    store3(b, kVelocityAt, i, select(rests, Floats3{}, v));
    if (p.bound.turns.up) store3(b, kSpinAt, i, select(rests, Floats3{}, load3(b, kSpinAt, i)));
    if (p.bound.turns.orientation) store3(b, kWorldSpinAt, i, select(rests, Floats3{}, load3(b, kWorldSpinAt, i)));
    const Rotations q = load_rotations(b, i), now = unit(q);
    const Floats3 front = turned_z(now);
    const Mask down = dot(front, normal) < 0.0f;
    Rotations turn = shortest(front, select(down, Floats3{} - normal, normal), turned_y(now));
    const Mask turns = reduce(turn, cosine, sine);
    store_rotations(b, i, select(rests & turns, unit(turn * now), q));
  }
}

}  // namespace motes::MOTES_ISA
