#include "image/picture_light.h"

#include <stdexcept>

namespace motes::image {

void PictureLight::begin(const Grid& grid) {
  grid_ = grid;
  light_.resize(row_lanes() * static_cast<std::size_t>(grid.height));
}

std::uint32_t* PictureLight::at(const Area& area) {
  return light_.data() + static_cast<std::size_t>(area.y) * row_lanes() + static_cast<std::size_t>(area.x) * 3;
}

void PictureLight::finish(const PreparedScene& scene, std::span<std::uint8_t> pixels, threads::Pool& pool) {
  if (pixels.size() != light_.size()) throw std::invalid_argument("pixels must be height * width * 3 bytes");
  bloom_.spread({light_.data(), light_.size()}, grid_.width, grid_.height, scene.view().bloom, pool);
  constexpr std::size_t kSums = std::size_t{1} << 16;  // of one thread at a time
  threads::over_ranges(pool, light_.size(), kSums, [&](std::size_t first, std::size_t last) {
    lanes_->tone(light_.data() + first, last - first, scene.tone().data(), pixels.data() + first);
  });
}

std::vector<float> PictureLight::linear() const {
  std::vector<float> linear(light_.size());
  for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = static_cast<float>(light_.data()[i] / double{kUnit});
  return linear;
}

}  // namespace motes::image
