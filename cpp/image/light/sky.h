// The sky of a view as kernels read it, and its ambient light.
#pragma once

#include "image/light/texture.h"
#include "image/scene.h"

namespace motes::image {

struct SkyLanes {
  Sky::Kind kind = Sky::Kind::none;
  float color[3]{};  // the background, where there is no sky
  float horizon[3]{}, zenith[3]{}, ground[3]{};
  Texture picture{};
};

/// Ambient light on a surface. Of a background of one colour, it is linear in the y component of the surface's normal:
/// `high` if that is 1, `low` if it is -1. Of other skies it is their irradiance up to the second degree (Ramamoorthi
/// and Hanrahan 2001), from means over all directions d of the light L: of L, 2 L d and 15/8 L d d.
struct Ambient {
  bool of_sky = false;
  float low[3]{}, high[3]{};
  float mean[3]{}, slope[3][3]{};  // by axis, then channel
  float curve[6][3]{};  // of xx, yy, zz, 2 xy, 2 yz, 2 zx
};

/// Returns the sky of a view. Throws std::invalid_argument if this process does not have its picture.
SkyLanes sky_lanes(const View& view);

/// Returns the light of the sky on a white surface; of a background of one colour, as in daylight_parts.h.
Ambient ambient(const View& view);

/// Returns ambient light on a white surface with this unit normal.
std::array<double, 3> ambient_on(const Ambient& a, const Vector& normal);

}  // namespace motes::image
