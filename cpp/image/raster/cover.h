// What records of one colour cover, before it becomes light.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/tile_planes.h"

namespace motes::image {

/// The sums of weights at a tile's pixels, one number per pixel in place of three. The light of streaks is a weight
/// times a colour, without rounding: added up first and multiplied then, it is the same to the last bit.
///
/// Weights are added by blocks of two rows. So that a block's numbers stand beside each other, wherever its rows begin,
/// there are two planes: one has the rows 0 and 1, 2 and 3, ... in pairs, and the other -1 and 0, 1 and 2, ... In a
/// pair, the numbers of both rows take turns.
struct Cover {
  static constexpr int kPairStride = 2 * kPixelStride;
  /// From the plane of even first rows to that of odd ones.
  static constexpr int kOddRows = (kTile / 2 + 2) * kPairStride;
  static constexpr int kFirst = kPairStride;
  static constexpr std::size_t kNumbers = 2 * kOddRows + kFirst;

  std::uint16_t* weights = nullptr;  // the first pair's first pixel; 0 in each column of the tile once it is shown
  std::uint32_t* sums = nullptr;     // of weights for which there was no room any more: rows of kPixelStride
  std::uint32_t most = 0;            // that any of `weights` may be
  bool has_sums = false;             // others are 0
  std::uint32_t color = 0;           // and alpha, as in a record
  std::uint16_t light = 0;           // as WideRecord::light
  std::uint32_t records = 0;         // that are drawn into it, at most
  bool saturating = false;           // light may overflow the sums

  /// With more of them the light of a sum would not fit into 32 bits.
  static constexpr std::uint32_t kMost = 4096;
};

}  // namespace motes::image
