// random_acceleration: v += sample dt. random_velocity: v = sample. Samples are uniform in a shape.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

inline void random_acceleration(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  visit(*p.shape, [&](const auto& shape) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      Draws draws = draws_of(b, s, i);
      const Floats3 acceleration = shape.sample(draws);
      store3(b, kVelocityAt, i, load3(b, kVelocityAt, i) + acceleration * all(s.dt));
    }
  });
}

inline void random_velocity(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  visit(*p.shape, [&](const auto& shape) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      Draws draws = draws_of(b, s, i);
      store3(b, kVelocityAt, i, shape.sample(draws));
    }
  });
}

}  // namespace motes::MOTES_ISA
