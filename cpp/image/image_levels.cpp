#include "image/image_levels.h"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <mutex>

namespace motes::image {
namespace {

constexpr double kFull = 32767;  // products of 16-bit numbers with a sign have room for it

// The inverse of sRGB's curve, from + - * / alone: ((x + 0.055) / 1.055)^2.4 by Newton's method on y^5 = v^12.
double linear_of(double encoded) {
  if (encoded <= 0.04045) return encoded / 12.92;
  const double v = (encoded + 0.055) / 1.055;
  const double v3 = v * v * v, v12 = v3 * v3 * v3 * v3;
  double y = 1;  // from above: the function is convex, so it converges
  for (int i = 0; i < 60; ++i) {
    const double y4 = y * y * y * y;
    y -= (y4 * y - v12) / (5 * y4);
  }
  return y;
}

std::array<double, 256> linear_table() {
  std::array<double, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = linear_of(static_cast<double>(i) / 255);
  return table;
}

std::size_t texel(int width, int x, int y) {
  return 4 * (static_cast<std::size_t>(y + 1) * static_cast<std::size_t>(width + 2) + static_cast<std::size_t>(x + 1));
}

std::vector<std::uint16_t> framed(int width, int height) {
  return std::vector<std::uint16_t>(4 * static_cast<std::size_t>(width + 2) * static_cast<std::size_t>(height + 2));
}

std::vector<std::uint16_t> first_level(const Picture& picture) {
  static const std::array<double, 256> linear = linear_table();
  std::vector<std::uint16_t> texels = framed(picture.width, picture.height);
  const std::uint8_t* from = picture.rgba.data();
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x, from += 4) {
      std::uint16_t* to = texels.data() + texel(picture.width, x, y);
      const double alpha = from[3] / 255.0;
      for (int c = 0; c < 3; ++c) to[c] = static_cast<std::uint16_t>(linear[from[c]] * alpha * kFull + 0.5);
      to[3] = static_cast<std::uint16_t>(alpha * kFull + 0.5);
    }
  }
  return texels;
}

// Means of 2x2 pixels; where a side is odd, what is beyond it is transparent.
std::vector<std::uint16_t> halved(const std::vector<std::uint16_t>& from, int from_width, int from_height, int width,
                                  int height) {
  std::vector<std::uint16_t> to = framed(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int right = std::min(2 * x + 1, from_width), below = std::min(2 * y + 1, from_height);
      for (std::size_t c = 0; c < 4; ++c) {
        const std::uint32_t sum = from[texel(from_width, 2 * x, 2 * y) + c] +
                                  from[texel(from_width, right, 2 * y) + c] +
                                  from[texel(from_width, 2 * x, below) + c] + from[texel(from_width, right, below) + c];
        to[texel(width, x, y) + c] = static_cast<std::uint16_t>((sum + 2) / 4);
      }
    }
  }
  return to;
}

}  // namespace

ImageLevels::ImageLevels(const Picture& picture) {
  int width = picture.width, height = picture.height;
  texels_.push_back(first_level(picture));
  levels_.push_back({texels_.back().data(), width, height});
  std::uint64_t alpha = 0;
  for (std::size_t i = 3; i < picture.rgba.size(); i += 4) alpha += picture.rgba[i];
  const double longer = std::max(width, height);
  cover_ = static_cast<double>(alpha) / (255 * longer * longer);
  while (width > 1 || height > 1) {
    const int half_width = (width + 1) / 2, half_height = (height + 1) / 2;
    texels_.push_back(halved(texels_.back(), width, height, half_width, half_height));
    width = half_width;
    height = half_height;
    levels_.push_back({texels_.back().data(), width, height});
  }
}

const ImageLevels& image_levels(AssetKey key) {
  static std::mutex mutex;
  static std::map<AssetKey, std::unique_ptr<const ImageLevels>> all;
  const std::scoped_lock lock(mutex);
  auto& levels = all[key];
  if (levels == nullptr) levels = std::make_unique<const ImageLevels>(*picture(key));
  return *levels;
}

}  // namespace motes::image
