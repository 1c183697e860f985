#include "image/light/depth_map.h"

#include <algorithm>
#include <cmath>

namespace motes::image {
namespace {

// Returns places in a spiral of golden angles. The eight at its rim and four within are the first ones.
const DepthTaps& taps() {
  static const DepthTaps all = [] {
    constexpr double kCosine = -0.7373688780783197, kSine = 0.6754902942615238;
    DepthTaps made{};
    double x = 1, y = 0;
    for (int i = 0; i < DepthTaps::kAll; ++i) {
      const double radius = std::sqrt((i + 0.5) / DepthTaps::kAll);
      constexpr int kRim = 8, kInner = DepthTaps::kAll - kRim;
      const bool early = i % 6 == 2;
      const int within = early ? kRim + i / 6 : DepthTaps::kFirst + i - (i + 3) / 6;
      const int at = i >= kInner ? i - kInner : within;
      made.x[at] = static_cast<float>(x * radius);
      made.y[at] = static_cast<float>(y * radius);
      const double turned = x * kCosine - y * kSine;
      y = x * kSine + y * kCosine;
      x = turned;
    }
    return made;
  }();
  return all;
}

}  // namespace

void DepthMap::begin(const DepthSpace& space) {
  space_ = space;
  pages_.assign(static_cast<std::size_t>(space.planes()) * kDepthPages * kDepthPages, 0);
  texels_.assign(kTexels, kNoDepth);
}

float* DepthMap::page(std::size_t number) {
  if (pages_[number] == 0) {
    pages_[number] = static_cast<float>(texels_.size() / kTexels);
    texels_.resize(texels_.size() + kTexels, kNoDepth);
  }
  return texels_.data() + static_cast<std::size_t>(pages_[number]) * kTexels;
}

void DepthMap::merge(const DepthMap& other) {
  for (std::size_t number = 0; number < other.pages_.size(); ++number) {
    if (!other.has(number)) continue;
    keep_nearest_texels(other.texels_.data() + static_cast<std::size_t>(other.pages_[number]) * kTexels, page(number));
  }
}

DepthView DepthMap::view() const {
  if (texels_.size() <= kTexels) return {};
  return {space_, pages_.data(), texels_.data(), &taps()};
}

void keep_nearest_texels(const float* from, float* to) {
  for (std::size_t i = 0; i < DepthMap::kTexels; ++i) to[i] = std::max(to[i], from[i]);
}

}  // namespace motes::image
