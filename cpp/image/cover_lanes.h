// Streaks of one colour: their weights are added up, and become light together. A row of weights is a third of a row of
// light, and seldom crosses the border of a cache line.
#pragma once

#include "image/cover.h"
#include "image/patch_lanes.h"
#include "image/stamps.h"

namespace motes::MOTES_ISA {

/// A record's colour for the weights of stamps, in the units of sums.
MOTES_INLINE Tint stamp_tint(const Channels& channels, std::uint32_t color, std::uint32_t light) {
  Tint tint;
  tint.shift = image::kStampShift;
  for (int j = 0; j < (kParts < 3 ? kParts : 3); ++j) {
    const Uints products = products_of(channels, color, j);
    tint.part[j] = light == image::kAllLight ? (products + 8u) >> 4 : (products * light + (1u << 18)) >> 19;
  }
  // 65536 / 16 for an opaque one's weight of 255.
  tint.alpha = ((color >> 24) * (66053u * light >> 15)) >> 12;
  return tint;
}

MOTES_INLINE void add_cover(std::uint32_t* to, Eight weights) {
  Eight sum;
  __builtin_memcpy(&sum, to, sizeof sum);
  sum += weights;
  __builtin_memcpy(to, &sum, sizeof sum);
}

template <bool kSaturating, int kPart = 0>
MOTES_INLINE void show_eight(const Tint& tint, Eight cover, std::uint32_t* to) {
  using V = Part<kPart>;
  const V more = spread_eight<kPart>(cover) * part_of<kPart>(tint.part[kPart % 3]);
  V before;
  __builtin_memcpy(&before, to + kPart * kWidth, sizeof before);
  V sum = before + more;
  if (kSaturating) sum |= (V)(sum < before);  // a sum stays at its greatest value
  __builtin_memcpy(to + kPart * kWidth, &sum, sizeof sum);
  if constexpr (kPart + 1 < kParts) show_eight<kSaturating, kPart + 1>(tint, cover, to);
}

template <bool kSaturating>
void show_rows(const image::TilePlanes& tile, const image::Cover& cover, int rows) {
  const Tint tint = stamp_tint(channels(), cover.color, cover.light);
  for (int row = 0; row < rows; ++row) {
    std::uint32_t* weights = cover.weights + static_cast<std::ptrdiff_t>(row) * image::kPixelStride;
    std::uint32_t* light = tile.light + static_cast<std::ptrdiff_t>(row) * image::kLightStride;
    for (int column = 0; column < image::kTile; column += kStrip) {
      Eight covered;
      __builtin_memcpy(&covered, weights + column, sizeof covered);
      show_eight<kSaturating>(tint, covered, light + static_cast<std::ptrdiff_t>(3) * column);
      covered = Eight{};
      __builtin_memcpy(weights + column, &covered, sizeof covered);
    }
  }
}

/// Adds what is covered to the tile's light, and clears it, also beside a tile that is not whole.
inline void show_cover(const image::TilePlanes& tile, const image::Cover& cover, int rows) {
  cover.saturating ? show_rows<true>(tile, cover, rows) : show_rows<false>(tile, cover, rows);
}

}  // namespace motes::MOTES_ISA
