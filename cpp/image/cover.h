// What records of one colour cover, before it becomes light.
#pragma once

#include <cstdint>

namespace motes::image {

/// A plane of the sums of weights, one number per pixel in place of three. The light of streaks is a weight times a
/// colour, without rounding: added up first and multiplied then, it is the same to the last bit.
struct Cover {
  std::uint32_t* weights = nullptr;  // the tile's first pixel, rows of kPixelStride; 0 in each column once it is shown
  std::uint32_t color = 0;  // and alpha, as in a record
  std::uint16_t light = 0;  // as WideRecord::light
  std::uint32_t records = 0;  // that are drawn into it, at most
  bool saturating = false;  // light may overflow the sums

  /// With more of them the light of a sum would not fit into 32 bits.
  static constexpr std::uint32_t kMost = 4096;
};

}  // namespace motes::image
