// The sun and the lamps of a view, as kernels read them.
#pragma once

#include "base/vectors.h"
#include "image/scene.h"

namespace motes::image {

/// A lamp. `spot` is the direction of its cone, a unit vector; beyond the angle of cosine `cosine` from it there is no
/// light, and all of it where the cosine is greater by 1 / per_cosine. per_cosine 0: it shines everywhere.
struct Lamp {
  float position[3];  // m, from the origin that its user chose
  float color[3];     // light on a surface that faces it at 1 m
  float spot[3];
  float cosine, per_cosine;
};

/// `origin`: of positions.
Lamp lamp_of(const Light& light, const Vector& origin = {});

struct Sun {
  bool shines = false;
  float toward[3]{};  // a unit vector
  float color[3]{};   // light on a surface that faces it
};

Sun sun_of(const View& view);

}  // namespace motes::image
