// Births for scenes on simulated ranks.
#pragma once

#include "recording/births.h"

namespace test {

/// Returns a source of particles that fall on the ground at y = 0 and spread along x: this many per frame of 1/24 s.
inline motes::recording::Source falling_source(double per_frame) {
  motes::recording::Source source;
  source.shape = {motes::shapes::Kind::box, {-3, 0.2f, -1, 0.5f, 2, 1}};
  source.rate = 24 * per_frame;
  const motes::actions::distributions::InShape velocity{{motes::shapes::Kind::sphere, {1, -4, 0, 6}}};
  source.state = {{motes::particles::velocity, velocity}};
  return source;
}

}  // namespace test
