// Stamps: precomputed weights of streaks, reused from record to record.
#pragma once

#include <cstdint>

namespace motes::image {

/// Holds the weights of one streak: of a sprite of one size, one length and direction, at one of 16 sub-pixel
/// positions. They follow from the key alone, so it does not matter when they were computed. A point is brighter than a
/// disc of its size (2 px), so its key has size 1, which no disc has.
///
/// Rows are stored in pairs. A block is 8 pixels of both rows, whose weights alternate; a pair has one block per strip:
///
///   pair p, strip s:  upper row  u0 u1 ... u7     block = u0 l0 u1 l1 ... u7 l7  (16 bytes)
///                     lower row  l0 l1 ... l7
///   weights:          strip 0: blocks of pairs 0 .. pairs-1, then strip 1: ...
struct alignas(64) Stamp {
  static constexpr int kPairs = 16;
  static constexpr int kBlocks = 48;
  static constexpr int kBlock = 16;   // weights
  static constexpr int kNarrow = 5;

  std::uint32_t key = 0;             // 0: none
  std::int8_t first = 0;             // first row, relative to the row of the streak's middle
  std::int8_t left = 0, right = 0;   // columns [left, right) contain all pixels
  std::uint8_t strips = 0;           // 0: too large for a stamp
  std::uint8_t pairs = 0;
  std::uint8_t most = 0;             // the greatest weight
  std::uint8_t narrow = 0;           // 1: no row has more than kNarrow pixels
  std::uint8_t column[kPairs] = {};  // from `left` to each pair's first pixel

  /// Weights 0..255 on the scale of Footprint, in the layout drawn above.
  std::uint8_t weights[kBlocks * kBlock] = {};

  bool usable() const { return strips != 0; }
};

/// Scales weights by 2^kStampShift before a partly hidden streak is multiplied by its visible part; the tint is scaled
/// down to match.
inline constexpr int kStampShift = 6;

/// Number of stamps per painter (14 MB), allocated when it first draws such streaks.
inline constexpr int kStampBits = 14;
inline constexpr int kStamps = 1 << kStampBits;

}  // namespace motes::image
