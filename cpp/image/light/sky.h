// The sky of a view as kernels read it, and its ambient light.
#pragma once

#include "image/light/texture.h"
#include "image/scene.h"

namespace motes::image {

struct SkyLanes {
  Sky::Kind kind = Sky::Kind::none;
  float color[3]{};  // the background, where there is no sky
  float horizon[3]{}, zenith[3]{}, ground[3]{};
  TextureLevel picture{};
};

/// Ambient light on a surface, linear in the y component of its normal: `high` if that is 1, `low` if it is -1.
struct Ambient {
  float low[3]{}, high[3]{};
};

/// Returns the sky of a view. Throws std::invalid_argument if this process does not have its picture.
SkyLanes sky_lanes(const View& view);

/// Returns the light of the sky on a white surface; of a background of one colour, as in daylight_parts.h.
Ambient ambient(const View& view);

}  // namespace motes::image
