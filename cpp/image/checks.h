// Checks of pictures: the camera, the sky, objects and lights. Sprites have theirs in image/sprites.
#pragma once

#include "image/scene.h"

namespace motes::image {

/// Checks a view; throws std::invalid_argument naming the argument, its value and what is allowed.
void check(const View& view);

}  // namespace motes::image
