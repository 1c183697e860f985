// Finds where a ray meets an external object, in double precision, one ray at a time: the reference for the engine's
// vectors of rays.
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

/// Finds the first surface beyond `nearest`. Returns true and sets `hit` if one is nearer than `farthest`. Surfaces are
/// visible from both sides; a sphere is only its outer surface; discs, cylinders and cones keep their holes.
bool intersect(const shapes::Shape& shape, const Ray& ray, double nearest, double farthest, Hit& hit);

}  // namespace motes::image_test
