// Samples are uniform in a shape, one per particle and step:
//   random_acceleration  v += sample dt        random_velocity             v = sample
//   random_displacement  x += sample dt        random_rotational_velocity  rotational velocity = sample
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

/// Calls work(first particle, sample) for each vector of the block.
template <class Work>
MOTES_INLINE void for_samples(const actions::Parameters& p, const actions::Block& b, const actions::Step& s,
                              const Work& work) {
  particles::DrawKeys& keys = draws_of(s);
  visit(*p.shape, [&](const auto& shape) __attribute__((always_inline)) {
    constexpr bool kTogether = requires { std::decay_t<decltype(shape)>::kDrawsTogether; };
    for_draws<kTogether>(keys, b.ids, b.count, [&](std::size_t i, Draws& draws) __attribute__((always_inline)) {
      work(i, shape.sample(draws));
    });
  });
}

/// Adds sample * scale to the attribute at component `at`.
MOTES_OUTLINE void add_samples(const actions::Parameters& p, const actions::Block& b, const actions::Step& s, int at,
                               float scale) {
  for_samples(p, b, s, [&](std::size_t i, Floats3 sample) __attribute__((always_inline)) {
    store3(b, at, i, load3(b, at, i) + sample * all(scale));
  });
}

/// Sets the attribute at component `at`.
MOTES_OUTLINE void set_samples(const actions::Parameters& p, const actions::Block& b, const actions::Step& s, int at) {
  for_samples(p, b, s, [&](std::size_t i, Floats3 sample) __attribute__((always_inline)) { store3(b, at, i, sample); });
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
