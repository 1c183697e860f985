// Turns the optical depths of a shadow grid's boxes into the light that is left.
#pragma once

#include <cstdint>
#include <vector>

#include "image/light/shadow_grid.h"

namespace motes::image {

/// Writes the light that particles leave: see ShadowMap::left; leaves `left` empty if there are none. `sums`: those of
/// one light; `boxes`: one bit per box that has any.
void set_light_left(const ShadowSpace& space, const std::int64_t* sums, unsigned boxes, std::vector<float>& left);

}  // namespace motes::image
