// wind: v += (air - v) (1 - exp(-drag dt)), the effect of linear drag over dt in air of constant velocity: exact for
// any dt, and v never overshoots the air's velocity.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

inline void wind(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::wind>(p);
  const Floats3 air = all3(n.velocity);
  const Floats part = part_gone(all(n.drag * s.dt));
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 v = load3(b, kVelocityAt, i);
    store3(b, kVelocityAt, i, v + (air - v) * part);
  }
}

}  // namespace motes::MOTES_ISA
