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

/// Two knots of a ramp, and what is between them.
struct Segment {
  float from, to, per_ratio, low[3], rise[3], high[3];

  static MOTES_INLINE Segment of(const actions::Parameters& p, int width, int k) {
    const int here = k * (1 + width), next = here + 1 + width;
    Segment s{};
    s.from = number(p, here);
    s.to = number(p, next);
    s.per_ratio = s.to > s.from ? 1.0f / (s.to - s.from) : 0.0f;  // knots at the same ratio make a jump
    for (int c = 0; c < width; ++c) {
      s.low[c] = number(p, here + 1 + c);
      s.high[c] = number(p, next + 1 + c);
      s.rise[c] = s.high[c] - s.low[c];
    }
    return s;
  }
};

/// `width` components from the one at `at` on; a block's pass takes up to kSegments of the ramp.
template <int width>
MOTES_INLINE void over_life(const actions::Parameters& p, const actions::Block& b, int at) {
  constexpr int kSegments = 8;
  const int segments = p.numbers / (1 + width) - 1;
  for (int first = 0; first == 0 || first < segments; first += kSegments) {
    Segment segment[kSegments];
    int count = 0;
    for (; count < kSegments && first + count < segments; ++count)
      segment[count] = Segment::of(p, width, first + count);
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      const Floats ratio = life_ratio(b, i);
      Floats y[width];
      for (int c = 0; c < width; ++c) y[c] = first == 0 ? all(number(p, 1 + c)) : load(b.component[at + c] + i);
      for (int k = 0; k < count; ++k) {
        const Segment& s = segment[k];
        const Floats part = (ratio - s.from) * s.per_ratio;
        const Mask reached = ratio >= s.from, passed = ratio >= s.to;
        for (int c = 0; c < width; ++c) {
          y[c] = select(passed, all(s.high[c]), select(reached, s.low[c] + part * s.rise[c], y[c]));
        }
      }
      for (int c = 0; c < width; ++c) store(b.component[at + c] + i, y[c]);
    }
  }
}

inline void color_over_life(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  over_life<3>(p, b, kColorAt);
}

inline void alpha_over_life(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  over_life<1>(p, b, kAlphaAt);
}

inline void size_over_life(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  over_life<3>(p, b, kSizeAt);
}

}  // namespace motes::MOTES_ISA
