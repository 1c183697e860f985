// speed_clamp: v keeps its direction and gets a speed in min_speed..max_speed; a particle at rest has no direction and
// stays at rest (McAllister's SpeedClamp).
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

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
