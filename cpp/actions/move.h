// move: x += v dt, age += dt without drift (grow_older.h); with `rotational`, up += rotational_velocity dt
// (McAllister's Move), and orientation turns by spin dt. A particle that would leave float32's range, or whose velocity
// is not finite, stays where it is and dies.
#pragma once

#include "actions/grow_older.h"
#include "actions/lanes.h"

namespace motes::MOTES_ISA {

/// Turns orientations. Without spin the bits do not change, so a rank whose particles all have no spin may skip the
/// column.
MOTES_INLINE void spin(const actions::Block& b, float dt) {
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Rotations from = load_rotations(b, i);
    const Floats3 rate = load3(b, kWorldSpinAt, i);
    const Mask turns = ((rate.x != 0.0f) | (rate.y != 0.0f) | (rate.z != 0.0f)) & finite(rate);
    store_rotations(b, i, select(turns, unit(rotation_by(rate * dt) * from), from));
  }
}

inline void move(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const Floats dt = all(s.dt);
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 from = load3(b, kPositionAt, i);
    Floats3 to = from + load3(b, kVelocityAt, i) * dt;
    if (!all_finite(to)) [[unlikely]] {
      const Mask lost = ~finite(to);
      to = select(lost, from, to);
      kill(b, i, lost);
    }
    store3(b, kPositionAt, i, to);
  }
  grow_older(b.component[kAgeAt], b.count, s.ageing);
  if (p.bound.turns.orientation) spin(b, s.dt);
  if (!p.bound.turns.up) return;
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 up = load3(b, kUpAt, i);
    const Floats3 spin = load3(b, kSpinAt, i);
    // Without spin the bits do not change, so a rank whose particles all have no spin may skip the column.
    const Mask turns = (spin.x != 0.0f) | (spin.y != 0.0f) | (spin.z != 0.0f);
    store3(b, kUpAt, i, select(turns, up + spin * dt, up));
  }
}

}  // namespace motes::MOTES_ISA
