// color_over_life, alpha_over_life, size_over_life: y = ramp(age / lifetime). A ramp is a list of knots (ratio, value):
// between two knots the value is linear, before the first and after the last it is constant. A particle that lives
// forever has ratio 0.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

/// Returns age / lifetime, clamped to where products with 0 are 0; ramps are constant beyond.
MOTES_INLINE Floats life_ratio(const actions::Block& b, std::size_t i) {
  const Floats age = load(b.component[kAgeAt] + i);
  const Floats lifetime = load(b.component[kLifetimeAt] + i);
  const Floats ratio = select(lifetime > 0.0f, age / lifetime, all(1.0f));
  return max(min(ratio, all(2.0f)), all(-1.0f));
}

/// A ramp of n knots has n + 1 parts: part k begins at knot k - 1, and the first one before all knots. On each part y =
/// low + (ratio - from) per_ratio rise.
template <class Number, int width>
struct RampPart {
  Number from, per_ratio, low[width], rise[width];
};

MOTES_INLINE float ramp_number(const actions::Parameters& p, int i) { return static_cast<float>(p.number[i]); }

template <int width>
MOTES_INLINE RampPart<float, width> ramp_part(const actions::Parameters& p, int k) {
  const int row = 1 + width, knots = p.bound.ramp / row;
  const int here = k > 0 ? (k - 1) * row : 0, next = k < knots ? k * row : here;
  RampPart<float, width> part{};
  part.from = ramp_number(p, here);
  const float length = ramp_number(p, next) - part.from;
  part.per_ratio = length > 0 ? 1.0f / length : 0.0f;  // knots at the same ratio make a jump
  for (int c = 0; c < width; ++c) {
    part.low[c] = ramp_number(p, here + 1 + c);
    part.rise[c] = ramp_number(p, next + 1 + c) - part.low[c];
  }
  return part;
}

/// Evaluates ramps whose parts fit into a register: each particle looks up its own part.
template <int width>
MOTES_INLINE void short_ramp(const actions::Parameters& p, const actions::Block& b, int at) {
  const int knots = p.bound.ramp / (1 + width);
  RampPart<Floats, width> table{};
  Floats knot[kTable > 0 ? kTable : 1];
  for (int k = 0; k <= knots; ++k) {
    const RampPart<float, width> part = ramp_part<width>(p, k);
    if (k > 0) knot[k - 1] = all(part.from);
    table.from[k] = part.from;
    table.per_ratio[k] = part.per_ratio;
    for (int c = 0; c < width; ++c) {
      table.low[c][k] = part.low[c];
      table.rise[c][k] = part.rise[c];
    }
  }
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats ratio = life_ratio(b, i);
    Ints index{};
    for (int k = 0; k < knots; ++k) index -= ratio >= knot[k];  // a true mask is -1
    const Floats in_part = (ratio - pick(table.from, index)) * pick(table.per_ratio, index);
    for (int c = 0; c < width; ++c) {
      store(b.component[at + c] + i, pick(table.low[c], index) + in_part * pick(table.rise[c], index));
    }
  }
}

/// Evaluates longer ramps: processes the block with up to kParts parts at a time.
template <int width>
MOTES_INLINE void long_ramp(const actions::Parameters& p, const actions::Block& b, int at) {
  constexpr int kParts = 8;
  const int parts = p.bound.ramp / (1 + width) + 1;
  for (int first = 0; first < parts; first += kParts) {
    RampPart<float, width> part[kParts];
    const int count = parts - first < kParts ? parts - first : kParts;
    for (int k = 0; k < count; ++k) part[k] = ramp_part<width>(p, first + k);
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      const Floats ratio = life_ratio(b, i);
      Floats y[width];
      for (int c = 0; c < width; ++c) y[c] = first == 0 ? all(part[0].low[c]) : load(b.component[at + c] + i);
      for (int k = first == 0 ? 1 : 0; k < count; ++k) {
        const Mask reached = ratio >= part[k].from;
        const Floats in_part = (ratio - part[k].from) * part[k].per_ratio;
        for (int c = 0; c < width; ++c) y[c] = select(reached, part[k].low[c] + in_part * part[k].rise[c], y[c]);
      }
      for (int c = 0; c < width; ++c) store(b.component[at + c] + i, y[c]);
    }
  }
}

/// Sets `width` components, starting at component `at`.
template <int width>
MOTES_INLINE void over_life(const actions::Parameters& p, const actions::Block& b, int at) {
  if (p.bound.ramp / (1 + width) < kTable) return short_ramp<width>(p, b, at);
  long_ramp<width>(p, b, at);
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
