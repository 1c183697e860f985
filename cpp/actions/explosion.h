// explosion: v += out magnitude dt g(d - radius) / (d^2 + epsilon), with d the distance from the centre, out the
// direction away from it and g the normal distribution's density of width sigma (McAllister's Explosion).
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

inline void explosion(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::explosion>(p);
  const float scale = n.magnitude * s.dt * (0.39894228f / n.sigma);  // 1 / sqrt(2 pi)
  const float inverse = 1.0f / n.sigma;
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 from_center = load3(b, kPositionAt, i) - all3(n.center);
    const Floats d2 = dot(from_center, from_center);
    const Floats d = sqrt(d2);
    const Floats sigmas = (d - n.radius) * inverse;
    // Beyond ten sigmas the density is below 1e-22 and would soon be denormal, which is very slow on many processors.
    const Floats square = sigmas * sigmas;
    const Floats push = exp(-0.5f * min(square, all(100.0f))) * (scale / (d * (d2 + n.epsilon)));
    const Mask pushed = (square < 100.0f) & (d2 > 0.0f);  // at the centre itself there is no direction
    store3(b, kVelocityAt, i, load3(b, kVelocityAt, i) + only(pushed, from_center * push));
  }
}

}  // namespace motes::MOTES_ISA
