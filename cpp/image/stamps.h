// Weights of streaks that are kept from record to record.
#pragma once

#include <cstdint>

namespace motes::image {

/// The streak of a sprite of one size, at one of 16 places in a pixel. What it holds follows from the key alone, so it
/// does not matter when it was computed.
struct Stamp {
  static constexpr int kRows = 32;  // times strips of 8 pixels

  std::uint64_t key = 0;  // 0: none
  std::int32_t first = 0, rows = 0, strips = 0;
  std::uint32_t number = 0;  // and shift: what a weight of 1 shines
  std::int32_t shift = 0;
  bool usable = false;  // false: too large to be kept
  std::int8_t start[kRows] = {};  // column of each row's first pixel
  std::uint16_t weights[kRows * 8] = {};
};

inline constexpr int kStampBits = 14;  // 10 MB, which a painter gets when it first draws such streaks
inline constexpr int kStamps = 1 << kStampBits;

}  // namespace motes::image
