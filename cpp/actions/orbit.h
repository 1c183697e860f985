// orbit_point, orbit_line: v += toward magnitude dt / (r^2 + epsilon) where r < max_radius, with r the distance from
// the point (the line) and toward the direction to it (McAllister's OrbitPoint, OrbitLine).
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

struct Pull {
  float strength, epsilon, max_radius2;

  MOTES_INLINE Mask reaches(Floats r2) const { return (r2 < max_radius2) & (r2 > 0.0f); }
  /// The change of velocity per metre of distance.
  MOTES_INLINE Floats per_metre(Floats r2) const { return strength / (sqrt(r2) * (r2 + epsilon)); }

  MOTES_INLINE Floats3 operator()(Floats3 toward) const {
    const Floats r2 = dot(toward, toward);
    return only(reaches(r2), toward * per_metre(r2));
  }
};

inline void orbit_point(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::orbit_point>(p);
  const Floats3 center = all3(n.center);
  const Pull pull{n.magnitude * s.dt, n.epsilon, n.max_radius * n.max_radius};
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 toward = center - load3(b, kPositionAt, i);
    store3(b, kVelocityAt, i, load3(b, kVelocityAt, i) + pull(toward));
  }
}

/// A line along a coordinate axis, the usual case, is a point in the plane of the other two.
MOTES_INLINE void orbit_axis(const actions::Block& b, const Pull& pull, Float3 point, int axis) {
  const int j = axis == 0 ? 1 : 0, k = axis == 2 ? 1 : 2;
  const float at[3] = {point.x, point.y, point.z};
  float *v_j = b.component[kVelocityAt + j], *v_k = b.component[kVelocityAt + k];
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats to_j = at[j] - load(b.component[kPositionAt + j] + i);
    const Floats to_k = at[k] - load(b.component[kPositionAt + k] + i);
    const Floats r2 = to_j * to_j + to_k * to_k;
    const Mask reached = pull.reaches(r2);
    const Floats change = pull.per_metre(r2);
    store(v_j + i, load(v_j + i) + only(reached, to_j * change));
    store(v_k + i, load(v_k + i) + only(reached, to_k * change));
  }
}

inline void orbit_line(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::orbit_line>(p);
  const Float3 point = of(n.point), along = of(n.axis);
  const Pull pull{n.magnitude * s.dt, n.epsilon, n.max_radius * n.max_radius};
  if (along.y == 0 && along.z == 0) return orbit_axis(b, pull, point, 0);
  if (along.x == 0 && along.z == 0) return orbit_axis(b, pull, point, 1);
  if (along.x == 0 && along.y == 0) return orbit_axis(b, pull, point, 2);
  const Floats3 axis = all3(unit(along));
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 from_point = load3(b, kPositionAt, i) - all3(point);
    const Floats3 toward = axis * dot(from_point, axis) - from_point;
    store3(b, kVelocityAt, i, load3(b, kVelocityAt, i) + pull(toward));
  }
}

}  // namespace motes::MOTES_ISA
