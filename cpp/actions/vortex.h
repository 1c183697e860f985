// vortex: a whirl around the axis, from the tip to the axis's end. At the fraction h (0..1) of the axis its radius is R
// = max_radius h^tightness. With r the distance from the axis and m the mass:
//   r < R               v = (along up_speed + around around_speed) dt / m
//   R <= r < max_radius v += inward in_speed dt / m
// along is the axis's direction, inward the direction to the axis, around = along x inward. Beyond the ends of the axis
// and beyond max_radius nothing happens. (McAllister's Vortex, which also replaces the velocity inside.)
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

struct Whirl {
  Float3 tip, along;
  float per_length, tightness, max_radius, in_speed, up_speed, around_speed;

  static MOTES_INLINE Whirl from(const actions::Parameters& p) {
    const auto n = numbers_of<numbers::vortex>(p);
    const Float3 axis = of(n.axis);
    return {of(n.tip),  unit(axis),    1.0f / __builtin_sqrtf(dot(axis, axis)), n.tightness, n.max_radius, n.in_speed,
            n.up_speed, n.around_speed};
  }

  /// Returns the new velocity. dt_by_m: seconds divided by mass.
  MOTES_INLINE Floats3 operator()(Floats3 x, Floats3 v, Floats dt_by_m) const {
    const Floats3 from_tip = x - all3(tip);
    const Floats height = dot(from_tip, all3(along));
    const Floats3 to_axis = all3(along) * height - from_tip;
    const Floats r2 = dot(to_axis, to_axis);
    const Floats part = height * per_length;
    const Mask reached = (part >= 0.0f) & (part <= 1.0f) & (r2 < max_radius * max_radius);
    if (!any(reached)) return v;
    // The lower bound keeps the logarithm finite at the tip; its power is still 0.
    const Floats width = max_radius * exp(tightness * log(min(max(part, all(1e-37f)), all(1.0f))));
    const Mask inside = r2 < width * width;
    const Floats3 inward = to_axis * select(r2 > 0.0f, 1.0f / sqrt(r2), Floats{});
    const Floats3 a = all3(along);
    const Floats3 around = {a.y * inward.z - a.z * inward.y, a.z * inward.x - a.x * inward.z,
                            a.x * inward.y - a.y * inward.x};
    const Floats3 whirling = (a * up_speed + around * around_speed) * dt_by_m;
    return select(reached, select(inside, whirling, v + inward * (in_speed * dt_by_m)), v);
  }
};

inline void vortex(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const Whirl whirl = Whirl::from(p);
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats mass = load(b.component[kMassAt] + i);
    const Floats3 v = load3(b, kVelocityAt, i);
    const Floats3 after = whirl(load3(b, kPositionAt, i), v, s.dt / mass);
    store3(b, kVelocityAt, i, select(mass != 0.0f, after, v));
  }
}

}  // namespace motes::MOTES_ISA
