// Checks and bounds of external objects.
#pragma once

#include "image/scene.h"

namespace motes::image {

/// Returns a bounding ball of a shape. Its radius is infinite for planes, and for meshes, whose BVH has bounds.
Ball bounds(const shapes::Shape& shape);

/// Throws std::invalid_argument if the shape is a union, a mesh, of a kind without a surface, or degenerate.
void check_solid(const std::string& argument, const Solid& solid);

}  // namespace motes::image
