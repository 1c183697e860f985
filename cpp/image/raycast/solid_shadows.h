// Soft shadows of solids on particles, from lights that have a size.
#pragma once

#include "image/light/particle_light.h"
#include "image/scene.h"

namespace motes::image {

/// Returns a function that computes the part of each light that solids leave visible; empty if there are no solids or
/// no light has a size.
InSight in_sight(const View& view);

}  // namespace motes::image
