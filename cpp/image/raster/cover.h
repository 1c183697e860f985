// The Cover: accumulated weights of records of one colour, before they become light.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/tile_planes.h"

namespace motes::image {

/// Sums of weights at a tile's pixels: one number per pixel instead of three. The light of a streak is weight times
/// colour, without rounding, so adding weights first and multiplying once gives the same bits.
///
/// Weights are added in blocks of two rows (see Stamp). Two planes hold pairs of rows, so that a block is contiguous
/// whether it begins in an even or an odd row; in a pair, the numbers of both rows alternate:
///
///   even plane:  rows 0|1, 2|3, ...     odd plane:  rows -1|0, 1|2, ...
///   pair a|b:    a0 b0 a1 b1 a2 b2 ...
struct Cover {
  static constexpr int kPairStride = 2 * kPixelStride;
  /// Offset from the even plane to the odd plane.
  static constexpr int kOddRows = (kTile / 2 + 2) * kPairStride;
  static constexpr int kFirst = kPairStride;
  static constexpr std::size_t kNumbers = 2 * kOddRows + kFirst;

  std::uint16_t* weights = nullptr;  // first pair's first pixel; all 0 in the tile's columns after it was shown
  std::uint32_t* sums = nullptr;     // 32-bit overflow of `weights`, rows of kPixelStride numbers
  std::uint32_t most = 0;            // bound on the greatest of `weights`
  bool has_sums = false;             // `sums` is in use; otherwise all 0
  std::uint32_t color = 0;           // colour and alpha, as in a record
  std::uint16_t light = 0;           // factor on alpha, as WideRecord::light
  std::uint32_t records = 0;         // bound on the number of records in it
  bool saturating = false;           // sums of light may overflow and must saturate

  /// Greatest number of records: the light of more would not fit into 32 bits.
  static constexpr std::uint32_t kMost = 4096;
};

}  // namespace motes::image
