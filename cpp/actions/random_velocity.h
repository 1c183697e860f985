// Samples are uniform in a shape, drawn anew for each particle and each step:
//   random_acceleration  v += sample dt        random_velocity             v = sample
//   random_displacement  x += sample dt        random_rotational_velocity  rotational velocity = sample
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

/// Adds sample * scale to the attribute at component `at`.
MOTES_INLINE void add_samples(const actions::Parameters& p, const actions::Block& b, const actions::Step& s, int at,
                              float scale) {
  particles::DrawKeys& keys = draws_of(s);
  const particles::DrawKey first = keys.first();
  visit(*p.shape, [&](const auto& shape) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      Draws draws(keys, first, b.ids, i);
      const Floats3 sample = shape.sample(draws);
      store3(b, at, i, load3(b, at, i) + sample * all(scale));
    }
  });
}

/// Sets the attribute at component `at`.
MOTES_INLINE void set_samples(const actions::Parameters& p, const actions::Block& b, const actions::Step& s, int at) {
  particles::DrawKeys& keys = draws_of(s);
  const particles::DrawKey first = keys.first();
  visit(*p.shape, [&](const auto& shape) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      Draws draws(keys, first, b.ids, i);
      store3(b, at, i, shape.sample(draws));
    }
  });
}

inline void random_acceleration(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  add_samples(p, b, s, kVelocityAt, s.dt);
}

inline void random_velocity(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  set_samples(p, b, s, kVelocityAt);
}

inline void random_displacement(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  add_samples(p, b, s, kPositionAt, s.dt);
}

inline void random_rotational_velocity(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  set_samples(p, b, s, kSpinAt);
}

}  // namespace motes::MOTES_ISA
