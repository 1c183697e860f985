// Turns the optical depths of a shadow grid's boxes into the light that is left.
#pragma once

#include <cstdint>
#include <vector>

#include "image/light/shadow_grid.h"

namespace motes::image {

/// Returns the light that particles leave: see ShadowMap::left; empty if there are none. `sums`: those of one light.
std::vector<float> light_left(const ShadowSpace& space, const std::int64_t* sums);

}  // namespace motes::image
