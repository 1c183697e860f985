// Mip levels of a sprite's picture.
#pragma once

#include <cstdint>
#include <vector>

#include "image/scene.h"
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

/// The mip levels of a picture's tiles, each about half the size of the one before, down to one pixel. Each level
/// covers its tile exactly, so none is displaced, and no tile bleeds into its neighbours.
class ImageLevels {
 public:
  ImageLevels(const meshes::Picture& picture, const Tiles& tiles);
  /// Returns the levels of all tiles in order, number() of each.
  const std::vector<ImageLevel>& levels() const { return levels_; }
  int number() const { return static_cast<int>(levels_.size() / cover_.size()); }
  /// Returns each tile's mean alpha over a square as wide as its longer side.
  const std::vector<float>& cover() const { return cover_; }

 private:
  void add(const meshes::Picture& tile);

  std::vector<std::vector<std::uint16_t>> texels_;
  std::vector<ImageLevel> levels_;
  std::vector<float> cover_;
};

/// Returns the levels of a picture's tiles, computed at first use and kept until the process ends. Thread-safe. Throws
/// std::invalid_argument if this process has no such picture, or the tiles do not divide it.
const ImageLevels& image_levels(meshes::AssetKey key, const Tiles& tiles);

}  // namespace motes::image
