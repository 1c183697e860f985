// The light on surfaces of particles, as painters apply it point by point: the same as on solids.
#pragma once

#include <memory>
#include <vector>

#include "image/light/lamps.h"
#include "image/light/sky.h"
#include "image/scene.h"

namespace motes::image {

/// Positions are metres from the camera's eye along the world's axes; surfaces are given in the camera's axes.
struct SurfaceLight {
  bool lit = false;  // by the sun, lamps and the sky; false: only as Daylight says
  float right[3], up[3], back[3];  // axes of the camera
  Ambient ambient;
  SkyLanes sky;
  Finish finish;
  Sun sun;
  std::vector<Lamp> lamps;
  const Lamp* lamp = nullptr;  // lamps.data()
  std::size_t count = 0;
  float fog[3]{}, fog_density = 0;  // 1/m; 0: no fog
};

/// Returns what the painter applies to a sprite; null: nothing.
std::shared_ptr<const SurfaceLight> surface_light(const Sprite& sprite, const View& view);

/// Returns the light on spheres that are not lit, or that have light of no colour: see Daylight.
std::shared_ptr<const SurfaceLight> grey_light(const View& view);

}  // namespace motes::image
