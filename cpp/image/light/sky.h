// The sky of a view as kernels take it, and the light that it throws on what is below it.
#pragma once

#include "image/light/texture.h"
#include "image/scene.h"

namespace motes::image {

struct SkyLanes {
  Sky::Kind kind = Sky::Kind::none;
  float color[3]{};  // kind none: the background
  float horizon[3]{}, zenith[3]{}, ground[3]{};
  TextureLevel picture{};
};

/// Ambient light on a surface, linear in the height of its normal: `high` where that points up, `low` where it points
/// down.
struct Ambient {
  float low[3]{}, high[3]{};
};

/// Throws std::invalid_argument where this process has not the picture.
SkyLanes sky_lanes(const View& view);

/// The light that a white surface has from the sky alone; of a background of one colour as in daylight_parts.h.
Ambient ambient(const View& view);

}  // namespace motes::image
