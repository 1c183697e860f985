// What the kernels share: planes of a block as vectors.
#pragma once

#include "actions/block.h"
#include "particles/schema.h"
#include "shapes/visit.h"

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

MOTES_INLINE Floats3 load3(const actions::Block& b, int at, std::size_t i) {
  return {load(b.component[at] + i), load(b.component[at + 1] + i), load(b.component[at + 2] + i)};
}
MOTES_INLINE void store3(const actions::Block& b, int at, std::size_t i, Floats3 v) {
  store(b.component[at] + i, v.x);
  store(b.component[at + 1] + i, v.y);
  store(b.component[at + 2] + i, v.z);
}
MOTES_INLINE Stream stream_of(const actions::Step& s) { return {s.step, s.stream, s.key}; }

/// The first draws of the block's particles; meanwhile the columns that will be needed soon are prefetched.
MOTES_INLINE void draw_block(const actions::Parameters& p, const actions::Block& b, const Stream& stream,
                             BlockBits& bits) {
  const float* column[actions::Ahead::kMost];
  const int columns = p.ahead != nullptr ? p.ahead->count : 0;
  for (int k = 0; k < columns; ++k) column[k] = b.component[p.ahead->column[k].component] + p.ahead->column[k].offset;
  bits.fill(stream, b.ids, b.count, [&column, columns](std::size_t i) __attribute__((always_inline)) {
    // Into the second-level cache: it can wait for more lines at once than the first-level cache.
    for (int k = 0; k < columns; ++k) __builtin_prefetch(column[k] + i, 0, 2);
  });
}
MOTES_INLINE void kill(const actions::Block& b, std::size_t i, Mask mask) {
  store_mask(b.dead + i, load_mask(b.dead + i) | mask);
}
MOTES_INLINE float number(const actions::Parameters& p, int i) { return static_cast<float>(p.number[i]); }

}  // namespace motes::MOTES_ISA
