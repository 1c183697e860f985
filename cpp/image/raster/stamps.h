// Weights of streaks that are kept from record to record.
#pragma once

#include <cstdint>

namespace motes::image {

/// The streak of a sprite of one size, at one of 16 places in a pixel. What it holds follows from the key alone, so it
/// does not matter when it was computed. A point shines more than a disc of its size, 2 px: its key has half of that,
/// which no disc has.
///
/// Its rows are kept in pairs, the first with the second: two rows of 8 pixels are a block, and a pair has as many
/// blocks beside each other as the stamp has strips.
struct alignas(64) Stamp {
  static constexpr int kPairs = 16;
  static constexpr int kBlocks = 48;
  static constexpr int kBlock = 16;   // weights
  static constexpr int kNarrow = 5;

  std::uint32_t key = 0;             // 0: none
  std::int8_t first = 0;             // from the middle's row
  std::int8_t left = 0, right = 0;   // columns before which, and from which on, no row has anything
  std::uint8_t strips = 0;           // 0: too large to be kept
  std::uint8_t pairs = 0;
  std::uint8_t most = 0;             // the greatest weight
  std::uint8_t narrow = 0;           // 1: no row has more than kNarrow pixels
  std::uint8_t column[kPairs] = {};  // from `left` to each pair's first pixel

  /// As a footprint's. In a block: of both rows' first pixels, then of their second ones, and so on. A strip's blocks
  /// follow one another.
  std::uint8_t weights[kBlocks * kBlock] = {};

  bool usable() const { return strips != 0; }
};

/// Where something hides a part of a streak its weights are multiplied by 2^6 first, and what they shine is divided.
inline constexpr int kStampShift = 6;

/// A painter gets so many when it first draws such streaks: 14 MB.
inline constexpr int kStampBits = 14;
inline constexpr int kStamps = 1 << kStampBits;

}  // namespace motes::image
