#include "image/raycast/solid_shadows.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "image/raycast/cast_scene.h"

namespace motes::image {

InSight in_sight(const View& view) {
  const bool sized = view.sun_size > 0 || std::any_of(view.lights.begin(), view.lights.end(),
                                                      [](const Light& light) { return light.radius > 0; });
  if (!sized || view.objects.empty()) return {};
  const auto scene = std::make_shared<CastScene>(view);  // keeps what the selection points to
  constexpr float kFar = std::numeric_limits<float>::max();
  const ShadeView& shade = scene->light({{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}});
  return [scene, &shade](const ParticlePlanes& particles, const ParticleWidth& width, std::size_t first,
                         std::size_t last, float* to, std::size_t stride) {
    std::size_t most = shade.cast.count;
    for (std::size_t k = 0; k < shade.light_count; ++k) most = std::max(most, shade.lights[k].count);
    std::vector<CastSolid> solids(most);
    std::vector<std::uint32_t> masks(most * NearSolids::kMostLanes);
    cast_lanes().in_sight(shade, {particles, width}, {solids.data(), masks.data()}, first, last, to, stride);
  };
}

}  // namespace motes::image
