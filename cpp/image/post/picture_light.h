// The light of a whole picture, if it is kept in addition to the pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/raster/splat_lanes.h"
#include "image/raycast/prepared_scene.h"
#include "threads/pool.h"

namespace motes::image {

/// Usage: begin for each frame; fill all tiles with sums of light, such as TileLight::copy_to() writes; then show,
/// unless tiles were shown one by one.
class PictureLight {
 public:
  explicit PictureLight(const SplatLanes& lanes = splat_lanes()) : lanes_(&lanes) {}

  /// Returns the bytes of a picture's sums.
  static std::size_t bytes(const Grid& grid) {
    return sizeof(std::uint32_t) * 3 * static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height);
  }

  /// Makes room for a picture of this size; its sums are undefined. Uses `memory`, of bytes(), unless it is null.
  void begin(const Grid& grid, std::shared_ptr<std::uint8_t[]> memory = nullptr);

  /// Returns the first sum of a tile; rows of the picture are row_lanes() apart.
  std::uint32_t* at(const Area& area);
  std::size_t row_lanes() const { return static_cast<std::size_t>(grid_.width) * 3; }

  /// Writes sRGB: height * width * 3 bytes, rows from top to bottom.
  void show(const PreparedScene& scene, std::span<std::uint8_t> pixels, threads::Pool& pool = threads::alone());

  /// Returns the picture before exposure and roll-off: linear RGB, height * width * 3.
  std::vector<float> linear() const;

 private:
  std::size_t lanes() const { return row_lanes() * static_cast<std::size_t>(grid_.height); }

  const SplatLanes* lanes_;
  Grid grid_;
  std::uint32_t* light_ = nullptr;  // lanes() sums, in one of these two
  BufferOf<std::uint32_t> own_;
  std::shared_ptr<std::uint8_t[]> given_;
};

}  // namespace motes::image
