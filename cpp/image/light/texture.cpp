#include "image/light/texture.h"

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>

namespace motes::image {
namespace {

struct KeptTexture {
  std::vector<std::vector<float>> pixels;
  std::vector<TextureLevel> levels;
  Texture texture{};
};

// The pixels of a side that one pixel of a side half as long averages: two, or three at the end of an odd side.
struct PixelPair {
  int first, last;
};
PixelPair pixel_pair(int i, int smaller, int larger) {
  return {std::min(2 * i, larger - 1), i + 1 == smaller ? larger - 1 : 2 * i + 1};
}

std::vector<float> half_as_large(const TextureLevel& from, int width, int height) {
  std::vector<float> to;
  to.reserve(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    const PixelPair rows = pixel_pair(y, height, from.height);
    for (int x = 0; x < width; ++x) {
      const PixelPair columns = pixel_pair(x, width, from.width);
      double sum[3] = {};
      for (int j = rows.first; j <= rows.last; ++j) {
        for (int i = columns.first; i <= columns.last; ++i) {
          const float* pixel = from.light + 3 * (static_cast<std::ptrdiff_t>(j) * from.width + i);
          for (int c = 0; c < 3; ++c) sum[c] += double{pixel[c]};
        }
      }
      const int count = (rows.last - rows.first + 1) * (columns.last - columns.first + 1);
      for (const double s : sum) to.push_back(static_cast<float>(s / count));
    }
  }
  return to;
}

std::unique_ptr<const KeptTexture> texture_levels_of(const meshes::Picture& picture) {
  if (picture.light.empty()) throw std::invalid_argument("a picture of a sky or solid must have light");
  auto kept = std::make_unique<KeptTexture>();
  kept->levels.push_back({picture.light.data(), picture.width, picture.height});
  while (kept->levels.back().width > 1 || kept->levels.back().height > 1) {
    const TextureLevel last = kept->levels.back();
    const int width = std::max(last.width / 2, 1), height = std::max(last.height / 2, 1);
    kept->pixels.push_back(half_as_large(last, width, height));
    kept->levels.push_back({kept->pixels.back().data(), width, height});
  }
  kept->texture = {kept->levels.data(), static_cast<int>(kept->levels.size())};
  return kept;
}

}  // namespace

const Texture& texture(meshes::AssetKey key) {
  static std::mutex mutex;
  static std::map<meshes::AssetKey, std::unique_ptr<const KeptTexture>> all;
  const std::scoped_lock lock(mutex);
  auto& kept = all[key];
  if (kept == nullptr) kept = texture_levels_of(*meshes::picture(key));
  return kept->texture;
}

}  // namespace motes::image
