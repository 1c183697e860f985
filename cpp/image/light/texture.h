// A picture of light on a surface or in the sky, with mip levels.
#pragma once

#include <vector>

#include "meshes/assets.h"

namespace motes::image {

/// One level: linear red, green, blue, rows from top to bottom.
struct TextureLevel {
  const float* light;
  int width, height;
};

/// The levels of a picture, as kernels read them: plain pointers into memory that stays valid until the process ends.
struct Texture {
  const TextureLevel* levels = nullptr;  // each about half the size of the one before, down to one pixel
  int count = 0;
};

/// Returns the levels of a picture, computed at first use. Thread-safe. Throws std::invalid_argument if this process
/// has no such picture, or it has no light.
const Texture& texture(meshes::AssetKey key);

}  // namespace motes::image
