// gravity: v += acceleration dt.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

inline void gravity(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::gravity>(p);
  const Floats3 change = all3(n.acceleration) * s.dt;
  for (std::size_t i = 0; i < b.count; i += kLanes) store3(b, kVelocityAt, i, load3(b, kVelocityAt, i) + change);
}

}  // namespace motes::MOTES_ISA
