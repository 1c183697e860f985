// Helpers for kernels: a block's planes as vectors, an action's numbers.
#pragma once

#include "actions/block.h"
#include "particles/schema.h"
#include "shapes/visit.h"
#include "simd/rotations.h"

namespace motes::MOTES_ISA {

// First components of the built-in attributes.
inline constexpr int kPositionAt = first_component(particles::position);
inline constexpr int kVelocityAt = first_component(particles::velocity);
inline constexpr int kUpAt = first_component(particles::up);
inline constexpr int kSpinAt = first_component(particles::rotational_velocity);
inline constexpr int kColorAt = first_component(particles::color);
inline constexpr int kAlphaAt = first_component(particles::alpha);
inline constexpr int kSizeAt = first_component(particles::size);
inline constexpr int kMassAt = first_component(particles::mass);
inline constexpr int kAgeAt = first_component(particles::age);
inline constexpr int kLifetimeAt = first_component(particles::lifetime);
inline constexpr int kPositionBAt = first_component(particles::position_b);
inline constexpr int kVelocityBAt = first_component(particles::velocity_b);
inline constexpr int kUpBAt = first_component(particles::up_b);
inline constexpr int kOrientationAt = first_component(particles::orientation);
inline constexpr int kWorldSpinAt = first_component(particles::spin);
inline constexpr int kHitAt = first_component(particles::hit);
inline constexpr int kHitNormalAt = first_component(particles::hit_normal);
inline constexpr int kLandingAt = first_component(particles::landing);

MOTES_INLINE Floats3 load3(const actions::Block& b, int at, std::size_t i) {
  return {load(b.component[at] + i), load(b.component[at + 1] + i), load(b.component[at + 2] + i)};
}
MOTES_INLINE void store3(const actions::Block& b, int at, std::size_t i, Floats3 v) {
  store(b.component[at] + i, v.x);
  store(b.component[at + 1] + i, v.y);
  store(b.component[at + 2] + i, v.z);
}
MOTES_INLINE Rotations load_rotations(const actions::Block& b, std::size_t i) {
  const float* const* q = b.component + kOrientationAt;
  return {load(q[0] + i), load(q[1] + i), load(q[2] + i), load(q[3] + i)};
}
MOTES_INLINE void store_rotations(const actions::Block& b, std::size_t i, Rotations r) {
  store3(b, kOrientationAt, i, {r.x, r.y, r.z});
  store(b.component[kOrientationAt + 3] + i, r.w);
}
/// Returns the keys of the action's draws in this step.
MOTES_INLINE particles::DrawKeys& draws_of(const actions::Step& s) {
  s.draws->begin(s.key, s.step, s.stream);
  return *s.draws;
}
MOTES_INLINE void kill(const actions::Block& b, std::size_t i, Mask mask) { b.dead[i / 32] |= bits_of(mask) << i % 32; }

/// Calls work(i) for each vector of the `count` particles for which test(i) is true in some lane. Usually there is
/// none, so four vectors are tested at once.
template <class Test, class Work>
MOTES_INLINE void where_any(std::size_t count, const Test& test, const Work& work) {
  std::size_t i = 0;
  for (; i + 3 * kLanes < count; i += 4 * kLanes) {
    if (!any((test(i) | test(i + kLanes)) | (test(i + 2 * kLanes) | test(i + 3 * kLanes)))) continue;
    for (std::size_t k = i; k < i + 4 * kLanes; k += kLanes) {
      if (any(test(k))) work(k);
    }
  }
  for (; i < count; i += kLanes) {
    if (any(test(i))) work(i);
  }
}

namespace numbers = actions::numbers;

/// Returns the action's numbers by name: numbers_of<numbers::wind>(p).drag.
template <template <class> class Numbers, class T = float>
MOTES_INLINE Numbers<T> numbers_of(const actions::Parameters& p) {
  return actions::read_numbers<Numbers, T>(p.number);
}

/// Returns the fraction of a velocity that linear drag removes over t >= 0 time constants: 1 - exp(-t). The series
/// avoids cancellation for small t.
MOTES_INLINE Floats part_gone(Floats t) {
  Floats series = all(1.0f / 720.0f);
  series = 1.0f / 120.0f - t * series;
  series = 1.0f / 24.0f - t * series;
  series = 1.0f / 6.0f - t * series;
  series = 0.5f - t * series;
  series = t * (1.0f - t * series);
  return select(t < 0.25f, series, 1.0f - exp(-min(t, all(80.0f))));
}

}  // namespace motes::MOTES_ISA
