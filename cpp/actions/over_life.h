// color_over_life, alpha_over_life, size_over_life: y = ramp(age / lifetime). A ramp is a list of knots (ratio, value):
// between two knots the value is linear, before the first and behind the last it is constant. A particle that lives for
// ever has ratio 0.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Floats life_ratio(const actions::Block& b, std::size_t i) {
  const Floats age = load(b.component[kAgeAt] + i);
  const Floats lifetime = load(b.component[kLifetimeAt] + i);
  return select(lifetime > 0.0f, age / lifetime, all(1.0f));
}

/// Component `c` (0.. width - 1) of the ramp, whose knots are rows of 1 + width numbers.
MOTES_INLINE Floats ramp_at(const actions::Parameters& p, int width, int c, Floats ratio) {
  const int row = 1 + width;
  const int knots = p.numbers / row;
  Floats y = all(number(p, 1 + c));
  for (int k = 0; k + 1 < knots; ++k) {
    const float from = number(p, k * row), to = number(p, (k + 1) * row);
    const float low = number(p, k * row + 1 + c), high = number(p, (k + 1) * row + 1 + c);
    // Knots at the same ratio make a jump.
    const float per_ratio = to > from ? 1.0f / (to - from) : 0.0f;
    y = select(ratio >= from, low + (ratio - from) * per_ratio * (high - low), y);
    y = select(ratio >= to, all(high), y);
  }
  return y;
}

MOTES_INLINE void over_life(const actions::Parameters& p, const actions::Block& b, int at, int width) {
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats ratio = life_ratio(b, i);
    for (int c = 0; c < width; ++c) store(b.component[at + c] + i, ramp_at(p, width, c, ratio));
  }
}

inline void color_over_life(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  over_life(p, b, kColorAt, 3);
}

inline void alpha_over_life(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  over_life(p, b, kAlphaAt, 1);
}

inline void size_over_life(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  over_life(p, b, kSizeAt, 3);
}

}  // namespace motes::MOTES_ISA
