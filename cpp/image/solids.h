// What may be an external object, and how much space it takes.
#pragma once

#include "image/scene.h"

namespace motes::image {

/// Return a ball around a shape; its radius is infinite for a plane.
Ball bounds(const shapes::Shape& shape);

/// Throws std::invalid_argument where the shape is a union, of a kind that has no surface, or degenerate.
void check_solid(const std::string& argument, const Solid& solid);

}  // namespace motes::image
