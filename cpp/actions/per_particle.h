// gravity_by, wind_by, damping_by, rotational_damping_by: the actions without `_by` with an expression for each of
// their numbers. Where a number is not finite (a speed: NaN), nothing changes; drag and damping below 0 count as 0.
#pragma once

#include "actions/evaluate.h"

namespace motes::MOTES_ISA {

inline void gravity_by(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const Values values(p, b, s);
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 acceleration = values.at3(0, i);
    store3(b, kVelocityAt, i, load3(b, kVelocityAt, i) + only(finite(acceleration), acceleration * s.dt));
  }
}

inline void wind_by(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const Values values(p, b, s);
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 air = values.at3(0, i), v = load3(b, kVelocityAt, i);
    const Floats drag = values.at(3, i);
    const Mask acts = finite(air) & (drag > 0.0f) & (drag <= __FLT_MAX__);
    store3(b, kVelocityAt, i, select(acts, v + (air - v) * part_gone(drag * s.dt), v));
  }
}

/// Slows the vectors down whose first component is at `at`.
MOTES_INLINE void damp_by(const actions::Parameters& p, const actions::Block& b, const actions::Step& s, int at) {
  const Values values(p, b, s);
  const auto lost = [&](Floats kept) { return (1.0f - max(kept, Floats{})) * s.dt; };
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 v = load3(b, at, i), kept = values.at3(0, i);
    const Floats low = values.at(3, i), high = values.at(4, i), speed2 = dot(v, v);
    const Mask acts = finite(kept) & (speed2 >= low * low) & (speed2 <= high * high);
    store3(b, at, i, v - only(acts, {v.x * lost(kept.x), v.y * lost(kept.y), v.z * lost(kept.z)}));
  }
}

inline void damping_by(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  damp_by(p, b, s, kVelocityAt);
}

inline void rotational_damping_by(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  damp_by(p, b, s, kSpinAt);
}

}  // namespace motes::MOTES_ISA
