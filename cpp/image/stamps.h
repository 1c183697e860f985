// Weights of streaks that are kept from record to record.
#pragma once

#include <cstdint>

namespace motes::image {

/// The streak of a sprite of one size, at one of 16 places in a pixel. What it holds follows from the key alone, so it
/// does not matter when it was computed.
struct alignas(64) Stamp {
  static constexpr int kRows = 32;      // times strips of 8 pixels
  static constexpr int kNarrow = 5;
  static constexpr int kMoreRows = 16;  // which may be read, too

  std::uint32_t key = 0;                          // 0: none
  std::int8_t first = 0, rows = 0;                // from the middle's row
  std::int8_t left = 0, right = 0;                // columns before which, and from which on, no row has anything
  std::uint8_t strips = 0;                        // 0: too large to be kept
  std::uint8_t narrow = 0;                        // 1: no row has more than kNarrow pixels
  std::int16_t lane[kRows + kMoreRows] = {};      // of light, from the middle's pixel to each row's first one
  std::int16_t pixel[kRows + kMoreRows] = {};     // as `lane`
  std::uint8_t weights[(kRows + kMoreRows) * 8] = {};  // as a footprint's; a strip's rows follow one another

  bool usable() const { return strips != 0; }
};

/// Where something hides a part of a streak its weights are multiplied by 2^6 first, and what they shine is divided.
inline constexpr int kStampShift = 6;

/// A painter gets so many when it first draws such streaks: 10 MB.
inline constexpr int kStampBits = 14;
inline constexpr int kStamps = 1 << kStampBits;

}  // namespace motes::image
