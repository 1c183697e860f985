// target_color, target_size, target_velocity, target_rotational_velocity: y += (target - y) scale dt
// (McAllister's TargetColor, TargetSize, TargetVelocity, TargetRotVelocity).
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

/// Moves one component of all particles toward `wanted` by the fraction `part`.
MOTES_INLINE void approach(const actions::Block& b, int at, float wanted, float part) {
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats y = load(b.component[at] + i);
    store(b.component[at] + i, y + (wanted - y) * part);
  }
}

inline void target_color(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::target_color>(p);
  const float part = n.scale * s.dt;
  for (int c = 0; c < 3; ++c) approach(b, kColorAt + c, n.color[c], part);
  approach(b, kAlphaAt, n.alpha, part);
}

inline void target_size(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::target_size>(p);
  for (int c = 0; c < 3; ++c) approach(b, kSizeAt + c, n.size[c], n.scale[c] * s.dt);
}

inline void target_velocity(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::target_velocity>(p);
  for (int c = 0; c < 3; ++c) approach(b, kVelocityAt + c, n.velocity[c], n.scale * s.dt);
}

inline void target_rotational_velocity(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::target_rotational_velocity>(p);
  for (int c = 0; c < 3; ++c) approach(b, kSpinAt + c, n.rotational_velocity[c], n.scale * s.dt);
}

}  // namespace motes::MOTES_ISA
