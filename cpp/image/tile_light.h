// A view of a tile's light in memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace motes::image {

/// Sums of light, three per pixel (see kUnit); rows are `row_lanes` apart.
struct TileLight {
  const std::uint32_t* first = nullptr;
  std::size_t row_lanes = 0;
  int width = 0, height = 0;
  int x = 0, y = 0;  // place in the picture

  const std::uint32_t* row(int y) const { return first + static_cast<std::size_t>(y) * row_lanes; }

  /// Copies the light to memory whose rows are `to_lanes` apart.
  void copy_to(std::uint32_t* to, std::size_t to_lanes) const {
    for (int y = 0; y < height; ++y, to += to_lanes) std::copy_n(row(y), 3 * width, to);
  }
};

}  // namespace motes::image
