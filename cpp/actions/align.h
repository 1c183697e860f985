// align: turns orientations the shortest way until their z axis (the front of a card or a mesh) points along the
// velocity or a given vector, by at most rate dt radians per step. A particle at rest has no direction and keeps its
// orientation.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

inline void align(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::align>(p);
  const Floats most = all(n.rate < 1e9f ? n.rate * s.dt : 1e9f);  // 1e9 exceeds any angle
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 wanted = n.velocity != 0 ? load3(b, kVelocityAt, i) : all3(n.to);
    const Floats length = sqrt(dot(wanted, wanted));
    const Mask known = (length > 1e-15f) & (length < 1e15f);
    const Floats3 to = wanted * (1.0f / select(known, length, all(1.0f)));
    const Rotations q = load_rotations(b, i);
    const Rotations now = unit(q);
    Rotations turn = shortest(turned_z(now), to, turned_y(now));
    // The length of a quaternion's vector part is the sine of half the angle. The turn is complete if the rate allows
    // it.
    const Floats half_sine = sqrt(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z);
    Floats cosine, sine;
    cos_sin(min(most * 0.5f, all(1.5707963f)), cosine, sine);
    const Mask part = half_sine > sine;
    const Floats scale = sine / select(part, half_sine, all(1.0f));
    turn = select(part, Rotations{turn.x * scale, turn.y * scale, turn.z * scale, cosine}, turn);
    store_rotations(b, i, select(known, unit(turn * now), q));
  }
}

}  // namespace motes::MOTES_ISA
