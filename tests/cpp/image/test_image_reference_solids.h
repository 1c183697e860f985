// Where a ray meets an external object, in double precision, one ray at a time: what the engine's vectors of rays are
// compared with.
#pragma once

#include "image/scene.h"

namespace motes::image_test {

struct Ray {
  Vector from;
  Vector along;  // of any length: distances are measured in units of it
};

struct Hit {
  double distance;
  Vector normal;  // unit, towards the side that the ray comes from
  int face;       // distinguishes faces that meet at an edge
};

/// The first surface beyond `nearest`: true, with `hit` set, where there is one nearer than `farthest`. Surfaces are
/// visible from both sides; a sphere is its outer surface only; discs, cylinders and cones keep their holes.
bool intersect(const shapes::Shape& shape, const Ray& ray, double nearest, double farthest, Hit& hit);

}  // namespace motes::image_test
