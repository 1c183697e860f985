// sink: kills inside (or outside) a shape. sink_velocity: tests the velocity instead of the position. kill_old: by age.
// kill_expired: age >= lifetime.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

/// Kills particles whose attribute at component `at` is inside, or outside, the shape.
MOTES_INLINE void kill_by_place(const actions::Parameters& p, const actions::Block& b, int at, bool inside) {
  visit(*p.shape, [&](const auto& shape) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      const Mask within = shape.contains(load3(b, at, i));
      kill(b, i, inside ? within : ~within);
    }
  });
}

inline void sink(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  kill_by_place(p, b, kPositionAt, numbers_of<numbers::sink>(p).inside != 0);
}

inline void sink_velocity(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  kill_by_place(p, b, kVelocityAt, numbers_of<numbers::sink_velocity>(p).inside != 0);
}

inline void kill_old(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  const auto n = numbers_of<numbers::kill_old>(p);
  const bool younger = n.younger != 0;
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats age = load(b.component[kAgeAt] + i);
    kill(b, i, younger ? age < n.age_limit : age >= n.age_limit);
  }
}

inline void kill_expired(const actions::Parameters&, const actions::Block& b, const actions::Step&) {
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    kill(b, i, load(b.component[kAgeAt] + i) >= load(b.component[kLifetimeAt] + i));
  }
}

}  // namespace motes::MOTES_ISA
