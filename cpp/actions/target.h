// target_color, target_size, target_velocity, target_rotational_velocity: y += (target - y) scale dt
// (McAllister's TargetColor, TargetSize, TargetVelocity, TargetRotVelocity).
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

/// One component: its target is number `target` of the action.
MOTES_INLINE void approach(const actions::Parameters& p, const actions::Block& b, int at, int target, float part) {
  const float wanted = number(p, target);
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats y = load(b.component[at] + i);
    store(b.component[at] + i, y + (wanted - y) * part);
  }
}

inline void target_color(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const float part = number(p, 4) * s.dt;
  for (int c = 0; c < 3; ++c) approach(p, b, kColorAt + c, c, part);
  approach(p, b, kAlphaAt, 3, part);
}

inline void target_size(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  for (int c = 0; c < 3; ++c) approach(p, b, kSizeAt + c, c, number(p, 3 + c) * s.dt);
}

inline void target_velocity(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  for (int c = 0; c < 3; ++c) approach(p, b, kVelocityAt + c, c, number(p, 3) * s.dt);
}

inline void target_rotational_velocity(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  for (int c = 0; c < 3; ++c) approach(p, b, kSpinAt + c, c, number(p, 3) * s.dt);
}

}  // namespace motes::MOTES_ISA
