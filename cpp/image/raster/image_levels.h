// A sprite's picture, ready to be drawn at any size.
#pragma once

#include <cstdint>
#include <vector>

#include "meshes/assets.h"

namespace motes::image {

/// Linear light times alpha, and alpha: 0..32767, four numbers per pixel; a frame of one transparent pixel surrounds
/// it.
struct ImageLevel {
  const std::uint16_t* texels;  // the first pixel of the frame
  int width, height;            // without the frame
  /// How many of its pixels cover as much of the picture as one of exactly half the size, a quarter of it and so on:
  /// 1 where sides are powers of two.
  float across, down;
  std::uint16_t most_alpha;  // of its pixels, at least 1
};

/// The picture, and smaller ones, each of about half the size of the one before, down to one pixel. Each covers the
/// picture exactly, so that none is beside its place.
class ImageLevels {
 public:
  explicit ImageLevels(const meshes::Picture& picture);
  const std::vector<ImageLevel>& levels() const { return levels_; }
  /// The part of a square as wide as the picture's longer side that it covers.
  double cover() const { return cover_; }

 private:
  std::vector<std::vector<std::uint16_t>> texels_;
  std::vector<ImageLevel> levels_;
  double cover_ = 0;
};

/// Computed at first use, kept until the process ends; thread-safe. Throws std::invalid_argument where this process
/// keeps no such picture.
const ImageLevels& image_levels(meshes::AssetKey key);

}  // namespace motes::image
