// A patch: the pixels around one sprite. Their weights are computed first, then its light is drawn row by row.
#pragma once

#include "image/raster/pixel_lanes.h"
#include "simd/shorts.h"

namespace motes::MOTES_ISA {

/// Pixels per strip in which rows are drawn: 24 lanes of light.
inline constexpr int kStrip = 8;
inline constexpr int kPatchRows = 64;
inline constexpr int kPatchStrips = 9;  // a tile's columns, wherever the first strip starts
inline constexpr int kPatchPixels = kPatchRows * kPatchStrips * kStrip;
/// Rows of a strip in one vector of 16-bit numbers.
inline constexpr int kRowsAtOnce = kShorts / kStrip;
/// Weights are computed for up to this many rows more than the patch has.
inline constexpr int kMoreRows = 16;

/// A part of a sprite's rows, cut into strips of 8 pixels. Weights of strip k, row r begin at 8 * (k * stride + r):
///
///   strip 0: row 0 (8 numbers), row 1, ... row stride-1; strip 1: ...
struct PatchPart {
  int first, rows;  // pixels of the tile
  int stride;       // `rows`, rounded up to whole vectors
  int strips;
  std::int32_t start[kPatchRows + kMoreRows];  // column of each row's first pixel
};

/// Holds 15-bit weights of a patch. kPlanes:
///
///   1  cover only: a pixel is as bright as it is covered
///   2  cover, and light (one number per pixel)
///   4  cover, and coloured light (three numbers per pixel)
template <int kPlanes>
struct Patch : PatchPart {
  alignas(64) std::uint16_t cover[kPatchPixels + 64];
  alignas(64) std::uint16_t light[kPlanes == 1 ? 1 : (kPlanes == 2 ? 1 : 3) * kPatchPixels + 64];
};

/// The pixels that a sprite may light: rows of equal width, each starting `slope` px to the right of the one above.
struct Outline {
  int first, last;    // rows
  float left, slope;  // `left`: where the row through the sprite's middle begins, px
  int strips;
};

MOTES_INLINE float size_of(float v) { return v < 0 ? -v : v; }
MOTES_INLINE int floor_of(float v) {
  const int towards_zero = static_cast<int>(v);
  return towards_zero - (static_cast<float>(towards_zero) > v);
}

/// Rows at least this wide, px, do not follow a slanted streak: it would save too little.
inline constexpr float kWideRow = 24;

/// Returns the outline of a sprite that fills a box of half sides box_x, box_y around its middle and moves along its
/// streak. `reach`: greatest distance of its light from the streak's line, px.
template <class Sprite>
MOTES_INLINE Outline outline_of(const Sprite& s, float reach, float box_x, float box_y) {
  const float slope = size_of(s.along_y);
  const float extent_x = box_x + s.half * size_of(s.along_x), extent_y = box_y + s.half * slope;
  Outline o;
  o.first = floor_of(s.y - extent_y) + 1;
  o.last = floor_of(s.y + extent_y);
  float side = extent_x;
  o.slope = 0;
  if (s.half > 0 && reach < slope * extent_x && 2 * reach < slope * kWideRow) {
    side = reach / slope;
    o.slope = s.along_x / s.along_y;
  }
  o.left = s.x - side;
  o.strips = (static_cast<int>(2 * side) + kStrip) / kStrip;
  return o;
}

MOTES_INLINE Floats numbers_from(int first) {
  Floats v;
  for (int lane = 0; lane < kWidth; ++lane) v[lane] = static_cast<float>(lane);
  return v + static_cast<float>(first);
}

/// Sets up a part with rows first .. last and strips from .. from + strips - 1 of an outline.
template <class Sprite>
MOTES_INLINE void place_rows(PatchPart& p, const Sprite& s, const Outline& o, int first, int last, int from,
                             int strips) {
  p.first = first;
  p.rows = last - first + 1;
  p.stride = (p.rows + kRowsAtOnce - 1) / kRowsAtOnce * kRowsAtOnce;
  p.strips = strips;
  for (int i = 0; i < p.rows; i += kWidth) {
    const Floats left = (numbers_from(first + i) - s.y) * o.slope + o.left;
    const Ints towards_zero = to_ints(left);
    // Rounds down and adds 1 (a true lane is -1).
    store_mask(p.start + i, towards_zero + (to_floats(towards_zero) > left) + (1 + kStrip * from));
  }
}

MOTES_INLINE Shorts columns_of_lanes() {
  Shorts v;
  for (int lane = 0; lane < kShorts; ++lane) v[lane] = static_cast<std::int16_t>(lane % kStrip);
  return v;
}
MOTES_INLINE Shorts rows_of_lanes() {
  Shorts v;
  for (int lane = 0; lane < kShorts; ++lane) v[lane] = static_cast<std::int16_t>(lane / kStrip);
  return v;
}
/// Clears weights of rows beyond the last; the vector begins at row `row` of `rows`.
MOTES_INLINE Shorts rows_within(Shorts weights, int row, int rows) {
  return row + kRowsAtOnce > rows ? weights & (rows_of_lanes() < all_shorts(rows - row)) : weights;
}

// Eight pixels, one number each; light has 24 lanes for them.
using Eight = std::uint32_t __attribute__((vector_size(32)));

MOTES_INLINE Eight eight_of(std::uint32_t value) { return Eight{} + value; }
/// Loads 32 bytes.
MOTES_INLINE Eight load_words(const void* from) {
  Eight v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
MOTES_INLINE void store_words(void* to, Eight v) { __builtin_memcpy(to, &v, sizeof v); }
#if MOTES_WIDTH >= 256
MOTES_INLINE Eight load_eight(const std::uint8_t* from) {
  return (Eight)_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(from)));
}
MOTES_INLINE Eight load_eight(const std::uint16_t* from) {
  return (Eight)_mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
}
#else
template <class Narrow>
MOTES_INLINE Eight widened(const void* from) {
  Narrow v;
  __builtin_memcpy(&v, from, sizeof v);
  return __builtin_convertvector(v, Eight);
}
using EightBytes = std::uint8_t __attribute__((vector_size(8)));
using EightShorts = std::uint16_t __attribute__((vector_size(16)));
MOTES_INLINE Eight load_eight(const std::uint8_t* from) { return widened<EightBytes>(from); }
MOTES_INLINE Eight load_eight(const std::uint16_t* from) { return widened<EightShorts>(from); }
#endif

#if MOTES_WIDTH == 512
inline constexpr int kParts = 2;  // 16 lanes and 8
#else
inline constexpr int kParts = 24 / kWidth;
#endif
template <int kPart>
struct PartType {
  using Type = Uints;
};
#if MOTES_WIDTH == 512
template <>
struct PartType<1> {
  using Type = Eight;
};
#endif
/// Vector number kPart of the 24 lanes of light of eight pixels.
template <int kPart>
using Part = typename PartType<kPart>::Type;  // NOLINT(readability-redundant-typename): clang 14 needs it

template <int kPart>
MOTES_INLINE Part<kPart> spread_eight(Eight pixels) {
#if MOTES_WIDTH == 512
  if constexpr (kPart == 0) {
    const __m512i of = _mm512_set_epi32(5, 4, 4, 4, 3, 3, 3, 2, 2, 2, 1, 1, 1, 0, 0, 0);
    return (Uints)_mm512_maskz_permutexvar_epi32(0xffff, of, _mm512_castsi256_si512((__m256i)pixels));
  } else {
    return (Eight)_mm256_permutevar8x32_epi32((__m256i)pixels, _mm256_set_epi32(7, 7, 7, 6, 6, 6, 5, 5));
  }
#elif MOTES_WIDTH == 256
  constexpr int kFirst = 8 * kPart;
  return (Uints)_mm256_permutevar8x32_epi32(
      (__m256i)pixels, _mm256_set_epi32((kFirst + 7) / 3, (kFirst + 6) / 3, (kFirst + 5) / 3, (kFirst + 4) / 3,
                                        (kFirst + 3) / 3, (kFirst + 2) / 3, (kFirst + 1) / 3, kFirst / 3));
#else
  constexpr int kFirst = 4 * kPart;
  return Uints{pixels[kFirst / 3], pixels[(kFirst + 1) / 3], pixels[(kFirst + 2) / 3], pixels[(kFirst + 3) / 3]};
#endif
}

/// Loads vector kPart of 24 16-bit numbers.
template <int kPart>
MOTES_INLINE Part<kPart> load_part(const std::uint16_t* from) {
#if MOTES_WIDTH == 512
  if constexpr (kPart == 0) {
    return (Uints)_mm512_maskz_cvtepu16_epi32(0xffff, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)));
  } else {
    return load_eight(from + 16);
  }
#elif MOTES_WIDTH == 256
  return load_eight(from + 8 * kPart);
#else
  const std::uint16_t* at = from + 4 * kPart;
  return Uints{at[0], at[1], at[2], at[3]};
#endif
}

template <int kPart>
MOTES_INLINE Part<kPart> part_of(Uints whole) {
#if MOTES_WIDTH == 512
  if constexpr (kPart == 1) return (Eight)_mm512_castsi512_si256((__m512i)whole);
#endif
  if constexpr (kPart != 1 || MOTES_WIDTH != 512) return whole;
}

#if MOTES_WIDTH == 512
MOTES_INLINE Eight multiply_short(Eight a, Eight b) { return (Eight)_mm256_madd_epi16((__m256i)a, (__m256i)b); }
#elif MOTES_WIDTH != 256
MOTES_INLINE Eight multiply_short(Eight a, Eight b) { return a * b; }
#endif

/// A sprite's colour in the units of sums: (weight * part) >> shift is the light of a weight.
struct Tint {
  Uints part[3];
  std::uint32_t alpha;  // 65536 / 16 for an opaque sprite
  int shift;
};

/// Makes the tint for which the light of a weight of 1 is number / 2^shift. `number` has 15 bits, so faint sprites are
/// as precise as bright ones.
MOTES_INLINE Tint tint_of(const Channels& channels, std::uint32_t color, std::uint32_t number, int shift) {
  Tint tint;
  tint.shift = shift;
  for (int j = 0; j < (kParts < 3 ? kParts : 3); ++j) {
    tint.part[j] = (products_of(channels, color, j) * number + 0x8000u) >> 16;
  }
  tint.alpha = ((color >> 24) * 257u * number + 0x8000u) >> 16;
  return tint;
}

/// Makes the tint for which the light of a weight of 1 is `unit` (<= 1/1024), if colour and alpha are 1. Returns false
/// if that is too faint to be visible.
MOTES_INLINE bool tint_of(const Channels& channels, std::uint32_t color, float unit, Tint& tint) {
  const float scale = unit * (65536.0f * image::kUnit / (255.0f * 255.0f));
  std::uint32_t bits;
  __builtin_memcpy(&bits, &scale, sizeof bits);
  const int exponent = static_cast<int>(bits >> 23) - 127;  // 2^exponent <= scale
  if (14 - exponent > 30) return false;
  tint = tint_of(channels, color, (bits >> 9 & 0x3fffu) | 0x4000u, 14 - exponent);
  return true;
}

/// Returns the visible part of eight pixels, 0..4096: `walls` are depths of the tile, `depth` that of the particle, as
/// bits.
MOTES_INLINE Eight seen_of(const std::uint32_t* walls, std::uint32_t depth, float fade) {
  using Whole = std::int32_t __attribute__((vector_size(32)));
  const Eight wall = load_words(walls);
  const Eight visible = (Eight)((Whole)wall >= (Whole)eight_of(depth));  // compares bits of positive floats
  if (!(fade > 0)) return visible & 4096u;
  using Numbers = float __attribute__((vector_size(32)));
  float center;
  __builtin_memcpy(&center, &depth, sizeof center);
  Numbers room = ((Numbers)wall - center) * fade;
  room = room > 0.0f ? room : Numbers{};
  room = room < 1.0f ? room : Numbers{} + 1.0f;
  return visible & (Eight) __builtin_convertvector(room * 4096.0f + 0.5f, Whole);
}

/// Draws one row of a strip; `to` is the light of its first pixel, `lights` its coloured weights (kPlanes = 4). kUsed:
/// how many of the kParts vectors are drawn.
template <int kPlanes, bool kOver, bool kSaturating, bool kTest, int kPart = 0, int kUsed = kParts>
MOTES_INLINE void draw_row(const Tint& tint, std::uint32_t* to, Eight cover, Eight light, const std::uint16_t* lights,
                           Eight seen) {
  using V = Part<kPart>;
  V weight;
  if constexpr (kPlanes == 4) {
    weight = load_part<kPart>(lights);
    if (kTest) weight = weight * spread_eight<kPart>(seen) >> 12;
  } else {
    weight = spread_eight<kPart>(light);
  }
  const V more = multiply_short(weight, part_of<kPart>(tint.part[kPart % 3])) >> tint.shift;
  V before;
  __builtin_memcpy(&before, to + kPart * kWidth, sizeof before);
  if (kOver) before = behind(before, spread_eight<kPart>(cover));
  V sum = before + more;
  if (kSaturating) sum |= (V)(sum < before);
  __builtin_memcpy(to + kPart * kWidth, &sum, sizeof sum);
  if constexpr (kPart + 1 < kUsed) {
    draw_row<kPlanes, kOver, kSaturating, kTest, kPart + 1, kUsed>(tint, to, cover, light, lights, seen);
  }
}

/// Returns the opacity, 0..65535, of eight pixels that are covered this much: the argument of behind().
MOTES_INLINE Eight opacity_of(const Tint& tint, Eight cover) {
  const Eight part = multiply_short(cover, eight_of(tint.alpha)) >> (tint.shift + 4);
  const Eight opacity = part + (part >> 8);
  const Eight more = (Eight)(opacity > 65535u);
  return (opacity & ~more) | (more & 65535u);
}

/// Draws those rows of the patch that are in first .. last of the tile.
template <int kPlanes, bool kOver, bool kSaturating, bool kTest>
void draw_patch(const image::TilePlanes& tile, const Patch<kPlanes>& patch, const Tint& tint, int first, int last,
                int columns, std::uint32_t depth, float fade) {
  const int begin = first > patch.first ? first : patch.first;
  const int below = patch.first + patch.rows - 1, end = last < below ? last : below;
  for (int strip = 0; strip < patch.strips; ++strip) {
    for (int row = begin; row <= end; ++row) {
      const int column = patch.start[row - patch.first] + strip * kStrip;
      if (static_cast<unsigned>(column + kStrip - 1) >= static_cast<unsigned>(columns + kStrip - 1)) continue;
      const int at = kStrip * (strip * patch.stride + row - patch.first);
      Eight cover = load_eight(patch.cover + at), light = cover, seen{};
      if constexpr (kPlanes == 2) light = load_eight(patch.light + at);
      if (kTest) {
        seen = seen_of(tile.depth + static_cast<std::ptrdiff_t>(row) * image::kPixelStride + column, depth, fade);
        cover = cover * seen >> 12;
        light = light * seen >> 12;
      }
      const Eight opacity = kOver ? opacity_of(tint, cover) : Eight{};
      std::uint32_t* to = tile.light + static_cast<std::ptrdiff_t>(row) * image::kLightStride + 3 * column;
      draw_row<kPlanes, kOver, kSaturating, kTest>(tint, to, opacity, light,
                                                   kPlanes == 4 ? patch.light + 3 * at : nullptr, seen);
    }
  }
}

}  // namespace motes::MOTES_ISA
