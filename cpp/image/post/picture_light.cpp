#include "image/post/picture_light.h"

#include <algorithm>
#include <utility>

#include "base/invalid_argument.h"

namespace motes::image {

void PictureLight::begin(const Grid& grid, std::shared_ptr<std::uint8_t[]> memory) {
  grid_ = grid;
  given_ = std::move(memory);
  if (!given_) own_.resize(lanes());
  light_ = given_ ? reinterpret_cast<std::uint32_t*>(given_.get()) : own_.data();
}

std::uint32_t* PictureLight::at(const Area& area) {
  return light_ + static_cast<std::size_t>(area.y) * row_lanes() + static_cast<std::size_t>(area.x) * 3;
}

void PictureLight::show(const PreparedScene& scene, std::span<std::uint8_t> pixels, threads::Pool& pool) {
  if (pixels.size() != lanes()) throw base::InvalidArgument("pixels", "be height * width * 3 bytes");
  constexpr std::size_t kSums = std::size_t{1} << 16;  // converted by a thread at a time
  const std::size_t row = row_lanes(), rows = std::max<std::size_t>(kSums / row, 1);
  threads::over_ranges(pool, static_cast<std::size_t>(grid_.height), rows, [&](std::size_t first, std::size_t last) {
    for (std::size_t y = first; y < last; ++y) {
      lanes_->tone(light_ + y * row, row, 0, static_cast<int>(y), scene.tone().data(), pixels.data() + y * row);
    }
  });
}

std::vector<float> PictureLight::linear() const {
  std::vector<float> linear(lanes());
  for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = static_cast<float>(light_[i] / double{kUnit});
  return linear;
}

}  // namespace motes::image
