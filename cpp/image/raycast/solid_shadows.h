// Shadows of solids on particles, of lights that have a size.
#pragma once

#include "image/light/particle_light.h"
#include "image/scene.h"

namespace motes::image {

/// Returns what solids leave of a view's lights; empty where there are no solids, or no light has a size.
InSight in_sight(const View& view);

}  // namespace motes::image
