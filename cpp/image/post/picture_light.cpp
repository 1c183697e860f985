#include "image/post/picture_light.h"

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
  threads::over_ranges(pool, lanes(), kSums, [&](std::size_t first, std::size_t last) {
    lanes_->tone(light_ + first, last - first, scene.tone().data(), pixels.data() + first);
  });
}

std::vector<float> PictureLight::linear() const {
  std::vector<float> linear(lanes());
  for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = static_cast<float>(light_[i] / double{kUnit});
  return linear;
}

}  // namespace motes::image
