// sink: kills inside (or outside) a shape. sink_velocity: the same, with the velocity as a point in the shape's space.
// kill_old: by age. kill_expired: age >= lifetime.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

/// Kills by where the attribute at component `at` lies.
MOTES_INLINE void kill_by_place(const actions::Parameters& p, const actions::Block& b, int at) {
  const bool inside = p.number[0] != 0;
  visit(*p.shape, [&](const auto& shape) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      const Mask within = shape.contains(load3(b, at, i));
      kill(b, i, inside ? within : ~within);
    }
  });
}

inline void sink(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  kill_by_place(p, b, kPositionAt);
}

inline void sink_velocity(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  kill_by_place(p, b, kVelocityAt);
}

inline void kill_old(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  const float limit = number(p, 0);
  const bool younger = p.number[1] != 0;
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats age = load(b.component[kAgeAt] + i);
    kill(b, i, younger ? age < limit : age >= limit);
  }
}

inline void kill_expired(const actions::Parameters&, const actions::Block& b, const actions::Step&) {
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    kill(b, i, load(b.component[kAgeAt] + i) >= load(b.component[kLifetimeAt] + i));
  }
}

}  // namespace motes::MOTES_ISA
