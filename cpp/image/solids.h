// Where a ray meets an external object.
#pragma once

#include "image/scene.h"

namespace motes::image {

struct Ray {
  Vector from;
  Vector along;  // of any length: distances are measured in units of it
};

struct Hit {
  double distance;
  Vector normal;  // unit, towards the side that the ray comes from
  int face;       // distinguishes faces that meet at an edge
};

/// A ball around a shape; its radius is infinite for a plane.
struct Ball {
  Vector center;
  double radius;
};
Ball bounds(const shapes::Shape& shape);

/// Throws std::invalid_argument where the shape is a union, of a kind that has no surface, or degenerate.
void check_solid(const std::string& argument, const Solid& solid);

/// The first surface beyond `nearest`: true, with `hit` set, where there is one nearer than `farthest`. Surfaces are
/// visible from both sides; a sphere is its outer surface only; discs, cylinders and cones keep their holes.
bool intersect(const shapes::Shape& shape, const Ray& ray, double nearest, double farthest, Hit& hit);

}  // namespace motes::image
