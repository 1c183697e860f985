// restore: sets velocities that bring position to position_b, and up to up_b, within time_left. The path is the cubic
// that starts at x with velocity v and ends at B at rest; its velocity one step later, with q = dt / time_left (at most
// 1), is
//   v' = v ((1 - q) (1 - 3 q) - 0.0002 q) + (B - x) 6 q (1 - q) / time_left
// When no time is left, x = B and v = 0. (McAllister's Restore, whose path ends a ten-thousandth of v time_left short;
// the 0.0002 reproduces this.)
// copy_vertex_b: position_b = position and up_b = up; velocity_b = velocity (his CopyVertexB).
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

/// Moves the attribute at `from`, whose rate of change is at `rate`, towards the one at `to`.
MOTES_INLINE void lead(const actions::Block& b, float dt, float time_left, int from, int rate, int to) {
  if (time_left <= 0) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      store3(b, from, i, load3(b, to, i));
      store3(b, rate, i, {Floats{}, Floats{}, Floats{}});
    }
    return;
  }
  const float q = dt < time_left ? dt / time_left : 1.0f;
  const float keep = (1.0f - q) * (1.0f - 3.0f * q) - 0.0002f * q;
  const float pull = 6.0f * q * (1.0f - q) / time_left;
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 way = load3(b, to, i) - load3(b, from, i);
    store3(b, rate, i, load3(b, rate, i) * keep + way * pull);
  }
}

inline void restore(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::restore>(p);
  if (n.position != 0) lead(b, s.dt, n.time_left, kPositionAt, kVelocityAt, kPositionBAt);
  if (n.up != 0) lead(b, s.dt, n.time_left, kUpAt, kSpinAt, kUpBAt);
}

MOTES_INLINE void copy3(const actions::Block& b, int from, int to) {
  for (std::size_t i = 0; i < b.count; i += kLanes) store3(b, to, i, load3(b, from, i));
}

inline void copy_vertex_b(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  const auto n = numbers_of<numbers::copy_vertex_b>(p);
  if (n.position != 0) {
    copy3(b, kPositionAt, kPositionBAt);
    copy3(b, kUpAt, kUpBAt);
  }
  if (n.velocity != 0) copy3(b, kVelocityAt, kVelocityBAt);
}

}  // namespace motes::MOTES_ISA
