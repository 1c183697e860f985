// Where a ray meets an external object.
#pragma once

#include "image/scene.h"

namespace motes::image {

struct Ray {
  Vector from;
  Vector along;  // of any length: distances are in units of it
};

struct Hit {
  double distance;
  Vector normal;  // unit, towards the side that the ray comes from
  int face;       // tells apart faces that meet at an edge
};

/// A ball around a shape; of infinite radius around a plane.
struct Ball {
  Vector center;
  double radius;
};
Ball bounds(const shapes::Shape& shape);

/// Throws std::invalid_argument where the shape is a union, of a kind that has no surface, or degenerate.
void check_solid(const std::string& argument, const Solid& solid);

/// The first surface beyond `nearest`: true, and `hit` is set, where there is one nearer than `farthest`. Surfaces are
/// seen from both sides; a sphere is its outer surface; a disc, a cylinder and a cone have their hole.
bool intersect(const shapes::Shape& shape, const Ray& ray, double nearest, double farthest, Hit& hit);

}  // namespace motes::image
