// Advances ages by a step (ageing.h) in double precision, half a vector at a time.
#pragma once

#include <limits>

#include "actions/ageing.h"
#include "actions/lanes.h"
#include "simd/doubles.h"

namespace motes::MOTES_ISA {

/// Rounds to 53 - n bits, where `scale` is 2^n: the inner difference drops the low bits, the outer one is exact.
MOTES_INLINE Doubles leading_bits(Doubles v, double scale) {
  const Doubles scaled = v * scale;
  return scaled - (scaled - v);
}

/// Advances ages counted in sub-steps with 23 bits: rounding to float32's 24 bits has changed the count by less than
/// half of its last bit.
template <bool has_rest>
MOTES_INLINE Doubles by_substeps(Doubles age, const actions::Ageing& g) {
  const Doubles count = leading_bits(age * g.per_second, 0x1p30) + 1.0;
  if constexpr (has_rest) return count * g.length + count * g.rest;
  return count * g.length;
}

/// Advances ages counted in frames with 22 bits, one fewer because the elapsed part of the frame is subtracted.
MOTES_INLINE Doubles by_frames(Doubles age, const actions::Ageing& g) {
  return (leading_bits(age * g.frames_per_second - g.start, 0x1p31) + g.end) * g.frame;
}

/// Advances ages of any size, including NaN and ages too large to be counted in sub-steps.
MOTES_OUTLINE Floats older_at_any_age(Floats age, const actions::Ageing& g) {
  const double step = g.length + g.rest;
  const Doubles low = low_half(age), high = high_half(age);
  const Floats in_substeps = join(by_substeps<true>(low, g), by_substeps<true>(high, g));
  const Floats in_frames = join(by_frames(low, g), by_frames(high, g));
  const Floats beyond = join(low + step, high + step);
  const Floats size = abs(age);
  return select(size <= g.in_substeps, in_substeps, select(size <= g.in_frames, in_frames, beyond));
}

template <bool has_rest>
MOTES_INLINE Floats older(Floats age, const actions::Ageing& g) {
  if (any(~(abs(age) <= g.in_substeps))) [[unlikely]]
    return older_at_any_age(age, g);
  return join(by_substeps<has_rest>(low_half(age), g), by_substeps<has_rest>(high_half(age), g));
}

/// Advances all ages. Particles born together are adjacent, so a vector of ages equal to the one before it costs only a
/// comparison.
template <bool has_rest>
MOTES_INLINE void grow_older(float* ages, std::size_t count, const actions::Ageing& g) {
  Floats before = all(std::numeric_limits<float>::quiet_NaN()), after = before;
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Floats age = load(ages + i);
    if (any(age != before)) {
      before = age;
      after = older<has_rest>(age, g);
    }
    store(ages + i, after);
  }
}

inline void grow_older(float* ages, std::size_t count, const actions::Ageing& step) {
  const actions::Ageing g = step;  // stores cannot change a copy
  if (g.rest != 0) return grow_older<true>(ages, count, g);
  grow_older<false>(ages, count, g);
}

}  // namespace motes::MOTES_ISA
