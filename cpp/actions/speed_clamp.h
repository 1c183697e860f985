// speed_clamp: v keeps its direction and gets a speed in min_speed..max_speed; a particle at rest has no direction and
// stays at rest (McAllister's SpeedClamp).
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

inline void speed_clamp(const actions::Parameters& p, const actions::Block& b, const actions::Step&) {
  const float low = number(p, 0);
  const float high = number(p, 1);
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 v = load3(b, kVelocityAt, i);
    const Floats speed = sqrt(dot(v, v));
    const Mask slow = (speed < low) & (speed > 0.0f);
    const Mask fast = speed > high;
    const Floats wanted = select(slow, all(low), all(high));
    store3(b, kVelocityAt, i, select(slow | fast, v * (wanted / speed), v));
  }
}

}  // namespace motes::MOTES_ISA
