// Mip levels of a sprite's picture.
#pragma once

#include <cstdint>
#include <vector>

#include "meshes/assets.h"

namespace motes::image {

/// One mip level: premultiplied linear light and alpha, 0..32767, four numbers per pixel, with a border of one
/// transparent pixel.
struct ImageLevel {
  const std::uint16_t* texels;  // first pixel of the border
  int width, height;            // without the border
  /// Ratio of its sides to those of exact halving: 1 where sides are powers of two.
  float across, down;
  std::uint16_t most_alpha;  // greatest alpha of its pixels, at least 1
};

/// The picture and smaller levels, each about half the size of the one before, down to one pixel. Each covers the
/// picture exactly, so none is displaced.
class ImageLevels {
 public:
  explicit ImageLevels(const meshes::Picture& picture);
  const std::vector<ImageLevel>& levels() const { return levels_; }
  /// Returns the mean alpha over a square as wide as the picture's longer side.
  double cover() const { return cover_; }

 private:
  std::vector<std::vector<std::uint16_t>> texels_;
  std::vector<ImageLevel> levels_;
  double cover_ = 0;
};

/// Returns the levels of a picture, computed at first use and kept until the process ends. Thread-safe. Throws
/// std::invalid_argument if this process has no such picture.
const ImageLevels& image_levels(meshes::AssetKey key);

}  // namespace motes::image
