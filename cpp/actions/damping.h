// damping: v *= 1 - (1 - damping) dt, axis by axis, where min_speed <= |v| <= max_speed (McAllister's Damping).
// rotational_damping: the same for the rotational velocity (his RotDamping).
// speed_clamp: v keeps its direction and gets a speed in min_speed..max_speed; a particle at rest has no direction and
// stays at rest (his SpeedClamp).
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

template <class Numbers>
MOTES_INLINE void damp(const Numbers& n, const actions::Block& b, const actions::Step& s, int at) {
  const Floats3 loss = {all((1.0f - n.damping[0]) * s.dt), all((1.0f - n.damping[1]) * s.dt),
                        all((1.0f - n.damping[2]) * s.dt)};
  const float low = n.min_speed * n.min_speed;
  const float high = n.max_speed * n.max_speed;
  if (low == 0 && high > __FLT_MAX__) {  // no speed limits: the usual case
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      const Floats3 v = load3(b, at, i);
      store3(b, at, i, {v.x - v.x * loss.x, v.y - v.y * loss.y, v.z - v.z * loss.z});
    }
    return;
  }
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 v = load3(b, at, i);
    const Floats speed2 = dot(v, v);
    const Mask mask = (speed2 >= low) & (speed2 <= high);
    store3(b, at, i, v - only(mask, {v.x * loss.x, v.y * loss.y, v.z * loss.z}));
  }
}

inline void damping(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  damp(numbers_of<numbers::damping>(p), b, s, kVelocityAt);
}

inline void rotational_damping(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  damp(numbers_of<numbers::rotational_damping>(p), b, s, kSpinAt);
}

inline void speed_clamp(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  const auto n = numbers_of<numbers::speed_clamp>(p);
  const float low = n.min_speed, high = n.max_speed;
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 v = load3(b, kVelocityAt, i);
    const Floats square = dot(v, v);
    const Mask slow = (square < low * low) & (square > 0.0f);
    const Mask wrong = slow | (square > high * high);
    if (!any(wrong)) continue;  // the common case
    const Floats factor = select(slow, all(low), all(high)) / sqrt(square);
    store3(b, kVelocityAt, i, v * select(wrong, factor, all(1.0f)));
  }
}

}  // namespace motes::MOTES_ISA
