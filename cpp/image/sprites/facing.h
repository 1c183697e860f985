// What rotates a sprite in space.
#pragma once

#include <cstdint>

namespace motes::image {

/// What rotates a sprite: the particle's velocity, or its orientation.
enum class Facing : std::uint8_t { velocity, orientation };

}  // namespace motes::image
