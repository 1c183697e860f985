// orbit_point, orbit_line: v += toward magnitude dt / (r^2 + epsilon) where r < max_radius, with r the distance from
// the point (the line) and toward the direction to it (McAllister's OrbitPoint, OrbitLine).
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

struct Pull {
  float strength, epsilon, max_radius2;

  MOTES_INLINE Floats3 operator()(Floats3 v, Floats3 toward) const {
    const Floats r2 = dot(toward, toward);
    const Floats change = strength / (sqrt(r2) * (r2 + epsilon));
    return select((r2 < max_radius2) & (r2 > 0.0f), v + toward * change, v);
  }
};

inline void orbit_point(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const Float3 center = {number(p, 0), number(p, 1), number(p, 2)};
  const Pull pull{number(p, 3) * s.dt, number(p, 4), number(p, 5) * number(p, 5)};
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 toward = all3(center) - load3(b, kPositionAt, i);
    store3(b, kVelocityAt, i, pull(load3(b, kVelocityAt, i), toward));
  }
}

inline void orbit_line(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const Float3 point = {number(p, 0), number(p, 1), number(p, 2)};
  const Floats3 axis = all3(unit(Float3{number(p, 3), number(p, 4), number(p, 5)}));
  const Pull pull{number(p, 6) * s.dt, number(p, 7), number(p, 8) * number(p, 8)};
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 from_point = load3(b, kPositionAt, i) - all3(point);
    const Floats3 toward = axis * dot(from_point, axis) - from_point;
    store3(b, kVelocityAt, i, pull(load3(b, kVelocityAt, i), toward));
  }
}

}  // namespace motes::MOTES_ISA
