#include "image/light/surface_light.h"

#include <algorithm>

#include "image/camera.h"
#include "image/layout.h"

namespace motes::image {
namespace {

void put(const Vector& v, float* to) {
  for (std::size_t i = 0; i < 3; ++i) to[i] = static_cast<float>(v[i]);
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
  put(through.right, made->right);
  put(through.up, made->up);
  put(through.forward * -1.0, made->back);
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

}  // namespace motes::image
