// Accumulates weights of streaks of one colour and turns them into light together. A processor adds to memory about
// once in two cycles, whatever the width: a block of 16 weights in two rows costs a third of one row's light.
#pragma once

#include "image/raster/patch_lanes.h"
#include "image/raster/stamps.h"

namespace motes::MOTES_ISA {

/// Returns a record's tint for weights of stamps.
MOTES_INLINE Tint stamp_tint(const Channels& channels, std::uint32_t color, std::uint32_t light) {
  Tint tint;
  tint.shift = image::kStampShift;
  for (int j = 0; j < (kParts < 3 ? kParts : 3); ++j) {
    const Uints products = products_of(channels, color, j);
    tint.part[j] = light == image::kAllLight ? (products + 8u) >> 4 : (products * light + (1u << 18)) >> 19;
  }
  // 65536 / 16 for a weight of 255 of an opaque record.
  tint.alpha = ((color >> 24) * (66053u * light >> 15)) >> 12;
  return tint;
}

MOTES_INLINE void add_block(std::uint16_t* to, const std::uint8_t* weights) {
#if MOTES_WIDTH >= 256
  auto* at = reinterpret_cast<__m256i*>(to);
  const __m256i more = _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(weights)));
  _mm256_storeu_si256(at, _mm256_add_epi16(_mm256_loadu_si256(at), more));
#elif MOTES_WIDTH == 128
  auto* at = reinterpret_cast<__m128i*>(to);
  const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(weights)), zero = _mm_setzero_si128();
  _mm_storeu_si128(at, _mm_add_epi16(_mm_loadu_si128(at), _mm_unpacklo_epi8(bytes, zero)));
  _mm_storeu_si128(at + 1, _mm_add_epi16(_mm_loadu_si128(at + 1), _mm_unpackhi_epi8(bytes, zero)));
#else
  for (int i = 0; i < image::Stamp::kBlock; ++i) to[i] = static_cast<std::uint16_t>(to[i] + weights[i]);
#endif
}

/// Calls use(row, column, weights) for every eight pixels and clears their weights. Visits whole rows of kTile pixels,
/// and an even number of rows.
template <class Use>
MOTES_INLINE void take_weights(image::Cover& cover, int rows, const Use& use) {
  constexpr int kStride = image::Cover::kPairStride;
  std::uint16_t* even = cover.weights;
  for (int row = 0; row < rows; row += 2, even += kStride) {
    std::uint16_t* odd = even + image::Cover::kOddRows;
    for (int column = 0; column < image::kTile; column += kStrip) {
      const Eight both = load_words(even + 2 * column);
      const Eight above = load_words(odd + 2 * column), below = load_words(odd + kStride + 2 * column);
      use(row, column, (both & 0xffffu) + (above >> 16));
      use(row + 1, column, (both >> 16) + (below & 0xffffu));
      store_words(even + 2 * column, Eight{});
      store_words(odd + 2 * column, Eight{});
    }
  }
  for (int column = 0; column < image::kTile; column += kStrip) {
    store_words(even + image::Cover::kOddRows + 2 * column, Eight{});
  }
  cover.most = 0;
}

/// Moves the 16-bit weights into the 32-bit sums, to make room for more.
inline __attribute__((noinline)) void add_up(image::Cover& cover, int rows) {
  take_weights(cover, rows, [&](int row, int column, Eight weights) {
    std::uint32_t* to = cover.sums + static_cast<std::ptrdiff_t>(row) * image::kPixelStride + column;
    store_words(to, load_words(to) + weights);
  });
  cover.has_sums = true;
}

template <bool kSaturating, int kPart = 0>
MOTES_INLINE void show_eight(const Tint& tint, Eight cover, std::uint32_t* to) {
  using V = Part<kPart>;
  const V more = spread_eight<kPart>(cover) * part_of<kPart>(tint.part[kPart % 3]);
  V before;
  __builtin_memcpy(&before, to + kPart * kWidth, sizeof before);
  V sum = before + more;
  if (kSaturating) sum |= (V)(sum < before);  // saturates
  __builtin_memcpy(to + kPart * kWidth, &sum, sizeof sum);
  if constexpr (kPart + 1 < kParts) show_eight<kSaturating, kPart + 1>(tint, cover, to);
}

template <bool kSaturating, bool kSums>
void show_rows(const image::TilePlanes& tile, image::Cover& cover, int rows) {
  const Tint tint = stamp_tint(channels(), cover.color, cover.light);
  take_weights(cover, rows, [&](int row, int column, Eight weights) {
    if constexpr (kSums) {
      std::uint32_t* sums = cover.sums + static_cast<std::ptrdiff_t>(row) * image::kPixelStride + column;
      weights += load_words(sums);
      store_words(sums, Eight{});
    }
    show_eight<kSaturating>(tint, weights,
                            tile.light + static_cast<std::ptrdiff_t>(row) * image::kLightStride + 3 * column);
  });
}
template <bool kSaturating>
MOTES_INLINE void show_rows(const image::TilePlanes& tile, image::Cover& cover, int rows) {
  cover.has_sums ? show_rows<kSaturating, true>(tile, cover, rows) : show_rows<kSaturating, false>(tile, cover, rows);
}

/// Adds the accumulated weights to the tile's light and clears them.
inline void show_cover(const image::TilePlanes& tile, image::Cover& cover, int rows) {
  cover.saturating ? show_rows<true>(tile, cover, rows) : show_rows<false>(tile, cover, rows);
  cover.has_sums = false;
}

}  // namespace motes::MOTES_ISA
