#include "image/raycast/scenery_exposer.h"

#include <algorithm>
#include <limits>

namespace motes::image {
namespace {

constexpr std::size_t kRoom = 16;  // greatest number of lanes of any build
constexpr std::size_t kInPhase = static_cast<std::size_t>(kTile / 2) * (kTile / 2);  // of a phase

// Calls use(number, x, y) for each pixel of a phase.
template <class Use>
void for_each_in_phase(const Area& area, int phase, const Use& use) {
  std::size_t i = 0;
  for (int y = phase / 2; y < area.height; y += 2) {
    for (int x = phase % 2; x < area.width; x += 2, ++i) use(i, x, y);
  }
}

}  // namespace

void SceneryExposer::begin(const Scenery& scenery) {
  if (scenery_ == &scenery && version_ == scenery.version()) return;
  scenery_ = &scenery;
  version_ = scenery.version();
  for (auto& phases : shots_) {
    for (Shot& shot : phases) shot.scene.reset();
  }
  for (auto* places : {&x_, &y_}) places->resize(kInPhase + kRoom);
  for (auto& channel : light_) channel.resize(kInPhase + kRoom);
  for (auto* words : {&depth_, &shadows_}) words->resize(kInPhase + kRoom);
  sums_.resize(3 * (kInPhase + kRoom));
}

SceneryExposer::Shot& SceneryExposer::shot(int number, int phase) {
  Shot& shot = shots_[static_cast<std::size_t>(number)][static_cast<std::size_t>(phase)];
  if (shot.scene != nullptr) return shot;
  const Exposure& exposure = exposures().of[number][phase];
  const ExposedView seen = exposed_view(scenery_->view(), exposure);
  shot.scene = std::make_unique<CastScene>(seen.view, scenery_->shadows());
  shot.move_x = exposure.pixel_x - seen.shift_x;
  shot.move_y = exposure.pixel_y - seen.shift_y;
  return shot;
}

std::size_t SceneryExposer::place(const Shot& shot, const Area& area, int phase) {
  std::size_t count = 0;
  for_each_in_phase(area, phase, [&](std::size_t i, int x, int y) {
    x_[i] = static_cast<float>(area.x + x) + 0.5f + shot.move_x;
    y_[i] = static_cast<float>(area.y + y) + 0.5f + shot.move_y;
    count = i + 1;
  });
  return count;
}

void SceneryExposer::expose(int number, const Area& area, std::uint32_t* light, std::ptrdiff_t light_stride,
                            std::uint32_t* depth, std::ptrdiff_t depth_stride) {
  constexpr float kMost = std::numeric_limits<float>::max();
  for (int phase = 0; phase < kPhases; ++phase) {
    Shot& shot = this->shot(number, phase);
    const std::size_t count = place(shot, area, phase);
    const double left = static_cast<double>(area.x) + double{shot.move_x};
    const double top = static_cast<double>(area.y) + double{shot.move_y};
    const CastView& view = shot.scene->aim(left, top, left + area.width, top + area.height);
    const bool empty = view.count == 0 && !shot.scene->has_sky() && !view.glass;
    if (!empty) {
      Reach reach{{kMost, kMost, kMost}, {-kMost, -kMost, -kMost}};
      met_.resize(kInPhase, view.keeps_triangles());
      lanes_->cast(view, x_.data(), y_.data(), count, met_.from(0));
      lanes_->measure(view, x_.data(), y_.data(), count, met_.from(0), reach, depth_.data());
      const ShadeView& shade = shot.scene->light(reach);
      lanes_->shade(shade, x_.data(), y_.data(), count, met_.from(0),
                    {{light_[0].data(), light_[1].data(), light_[2].data()}, shadows_.data()});
      const float* planes[3] = {light_[0].data(), light_[1].data(), light_[2].data()};
      lanes_->store(planes, count, sums_.data());
    }
    for_each_in_phase(area, phase, [&](std::size_t i, int x, int y) {
      const std::uint32_t* from = empty ? scenery_->background().data() : sums_.data() + 3 * i;
      std::copy_n(from, 3, light + y * light_stride + 3 * x);
      depth[y * depth_stride + x] = empty ? Scenery::kNothing : depth_[i];
    });
  }
}

}  // namespace motes::image
