// What rotates a sprite in space.
#pragma once

#include <cstdint>

namespace motes::image {

/// What rotates a sprite: the particle's velocity, its orientation, or its `up` on a plane that faces the camera.
enum class Facing : std::uint8_t { velocity, orientation, camera };

}  // namespace motes::image
