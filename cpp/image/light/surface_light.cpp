#include "image/light/surface_light.h"

#include <algorithm>

#include "image/camera.h"
#include "image/layout.h"
#include "image/light/daylight.h"

namespace motes::image {
namespace {

void put(const Vector& v, float* to) {
  for (std::size_t i = 0; i < 3; ++i) to[i] = static_cast<float>(v[i]);
}

void put_axes(const Lens& through, SurfaceLight& to) {
  put(through.right, to.right);
  put(through.up, to.up);
  put(through.forward * -1.0, to.back);
}

// Returns whether the sprite's mesh has normals, or places on a picture, at its corners.
bool has_places(const Sprite& sprite) {
  const auto* own = sprite.as<MeshSprite>();
  return own != nullptr && (own->picture != 0 || !meshes::mesh(own->mesh)->normals.empty());
}

}  // namespace

std::shared_ptr<const SurfaceLight> surface_light(const Sprite& sprite, const View& view) {
  const bool fogged = fogged_by_painter(sprite, view);
  if (!lit_by_painter(sprite) && !fogged && !has_places(sprite)) return nullptr;
  auto made = std::make_shared<SurfaceLight>();
  made->lit = lit_by_painter(sprite);
  const Lens through = lens(view);
  put_axes(through, *made);
  if (made->lit) {
    made->ambient = ambient(view);
    made->sky = sky_lanes(view);
    made->finish = sprite.finish;
    made->sun = sun_of(view);
    for (const Light& light : view.lights) {
      if (sprite.lit && light.power > 0) made->lamps.push_back(lamp_of(light, through.eye));
    }
    made->lamp = made->lamps.data();
    made->count = made->lamps.size();
  }
  if (fogged) {
    std::copy(view.fog.color.begin(), view.fog.color.end(), made->fog);
    made->fog_density = 1 / view.fog.metres;
  }
  return made;
}

std::shared_ptr<const SurfaceLight> grey_light(const View& view) {
  auto made = std::make_shared<SurfaceLight>();
  made->lit = true;
  put_axes(lens(view), *made);
  const Daylight daylight(view);
  made->sun = sun_of(view);
  std::fill_n(made->sun.color, 3, static_cast<float>(daylight.sun()));
  std::fill_n(made->ambient.low, 3, static_cast<float>(daylight.low()));
  std::fill_n(made->ambient.high, 3, static_cast<float>(daylight.high()));
  return made;
}

}  // namespace motes::image
