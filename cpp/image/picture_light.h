// The light of a whole picture, where more is done with it than showing each tile: bloom, linear pictures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "image/bloom.h"
#include "image/buffer.h"
#include "image/grid.h"
#include "image/prepared_scene.h"
#include "image/splat_lanes.h"

namespace motes::image {

/// Usage: begin for each frame; fill all tiles with sums of light, such as TilePainter::sums() writes; then finish.
class PictureLight {
 public:
  /// Whether a picture of this view needs it: else each tile can be shown as soon as it is painted. (Layers do: reading
  /// them overwrites a tile's light.)
  static bool needed(const View& view, bool keep_linear) { return keep_linear || view.bloom > 0 || view.layers != 0; }

  explicit PictureLight(const SplatLanes& lanes = splat_lanes()) : lanes_(&lanes) {}

  /// Bytes of a picture's sums.
  static std::size_t bytes(const Grid& grid) {
    return sizeof(std::uint32_t) * 3 * static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height);
  }

  /// Makes room for a picture of this size; its sums are undefined. They stand in `memory` of bytes() where there is
  /// any.
  void begin(const Grid& grid, std::shared_ptr<std::uint8_t[]> memory = nullptr);

  /// The first sum of a tile; rows of the picture are row_lanes() apart.
  std::uint32_t* at(const Area& area);
  std::size_t row_lanes() const { return static_cast<std::size_t>(grid_.width) * 3; }

  /// Spreads light by the view's bloom, and writes sRGB: height * width * 3 bytes, rows from top to bottom.
  void finish(const PreparedScene& scene, std::span<std::uint8_t> pixels, threads::Pool& pool = threads::alone());

  /// The finished picture before exposure and roll-off: linear RGB, height * width * 3.
  std::vector<float> linear() const;

 private:
  std::size_t lanes() const { return row_lanes() * static_cast<std::size_t>(grid_.height); }

  const SplatLanes* lanes_;
  Grid grid_;
  std::uint32_t* light_ = nullptr;  // lanes() sums, in one of these two
  BufferOf<std::uint32_t> own_;
  std::shared_ptr<std::uint8_t[]> given_;
  Bloom bloom_;
};

}  // namespace motes::image
