// rest: particles that have landed in this sub-step (hits.h) and are slow lie down: they are put at their landing, stop
// and stop turning, and turn the shortest way until their z axis or its opposite is within an angle of the normal.
#pragma once

#include "actions/hits.h"

namespace motes::MOTES_ISA {

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
