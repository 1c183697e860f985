// Writes the selected lanes of vectors one after another, without branches: processors cannot predict well which lanes
// are selected.
#pragma once

#include "simd/simd.h"

namespace motes::MOTES_ISA {

// Whether one instruction moves the selected lanes to the front.
#define MOTES_PRESSES (MOTES_WIDTH >= 256 || MOTES_NEON)

#if MOTES_WIDTH == 256 || MOTES_NEON
/// The numbers of the lanes in each set, in ascending order; with NEON, which shuffles bytes, those of their bytes. The
/// entries behind them are unused.
inline constexpr std::size_t kUnit = MOTES_NEON ? 4 : 1;
struct LaneOrders {
  std::uint8_t of[1u << kLanes][kUnit * kLanes];
};
constexpr LaneOrders lane_orders() {
  LaneOrders orders{};
  for (unsigned set = 0; set < 1u << kLanes; ++set) {
    std::size_t count = 0;
    for (std::size_t unit = 0; unit < kUnit * kLanes; ++unit) {
      if ((set >> unit / kUnit & 1u) != 0) orders.of[set][count++] = static_cast<std::uint8_t>(unit);
    }
  }
  return orders;
}
inline constexpr LaneOrders kLaneOrders = lane_orders();
#endif

/// A selection of lanes. `pressed` moves them to the front of a vector, whose other lanes are then undefined.
/// `front_of` clears those other lanes in a mask that was made by comparing pressed vectors with 0.
class Selected {
 public:
  MOTES_INLINE explicit Selected(Mask chosen) : Selected(bits_of(chosen)) {}
  /// From one bit per lane, as `bits_of` returns them.
#if MOTES_WIDTH == 512
  MOTES_INLINE explicit Selected(unsigned set) : bits_(static_cast<__mmask16>(set)) {}
  MOTES_INLINE std::size_t number() const { return static_cast<std::size_t>(__builtin_popcount(bits_)); }
  MOTES_INLINE Uints pressed(Uints v) const { return (Uints)_mm512_maskz_compress_epi32(bits_, (__m512i)v); }
  MOTES_INLINE Mask front_of(Mask pressed) const { return pressed; }  // the lanes behind are 0 already

 private:
  __mmask16 bits_;
#elif MOTES_WIDTH == 256
  MOTES_INLINE explicit Selected(unsigned set)
      : order_(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(kLaneOrders.of[set])))),
        number_(static_cast<std::size_t>(__builtin_popcount(set))) {}
  MOTES_INLINE std::size_t number() const { return number_; }
  MOTES_INLINE Uints pressed(Uints v) const { return (Uints)_mm256_permutevar8x32_epi32((__m256i)v, order_); }
  MOTES_INLINE Mask front_of(Mask pressed) const {
    return pressed & (Ints{0, 1, 2, 3, 4, 5, 6, 7} < static_cast<std::int32_t>(number_));
  }

 private:
  __m256i order_;
  std::size_t number_;
#elif MOTES_NEON
  MOTES_INLINE explicit Selected(unsigned set)
      : order_(vld1q_u8(kLaneOrders.of[set])), number_(static_cast<std::size_t>(__builtin_popcount(set))) {}
  MOTES_INLINE std::size_t number() const { return number_; }
  MOTES_INLINE Uints pressed(Uints v) const { return (Uints)vqtbl1q_u8((uint8x16_t)v, order_); }
  MOTES_INLINE Mask front_of(Mask pressed) const { return pressed & first_lanes(number_); }

 private:
  uint8x16_t order_;
  std::size_t number_;
#else
  MOTES_INLINE explicit Selected(unsigned set) {
    std::uint32_t count = 0;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      place_[lane] = count;
      count += set >> lane & 1u;
    }
    number_ = count;
  }
  MOTES_INLINE std::size_t number() const { return number_; }
  /// Returns where a selected lane goes. The other lanes are overwritten by the next selected one.
  MOTES_INLINE std::uint32_t place(std::size_t lane) const { return place_[lane]; }

 private:
  std::uint32_t place_[kLanes];
  std::size_t number_;
#endif
};

/// Writes the selected lanes; there must be room for all lanes.
MOTES_INLINE void store_selected(std::uint32_t* to, const Selected& selected, Uints v) {
#if MOTES_PRESSES
  store_uints(to, selected.pressed(v));
#else
  for (std::size_t lane = 0; lane < kLanes; ++lane) to[selected.place(lane)] = v[lane];
#endif
}

/// Writes the selected lanes as 16 bits each, which they must fit; there must be room for all lanes.
MOTES_INLINE void store_selected(std::uint16_t* to, const Selected& selected, Uints v) {
#if MOTES_WIDTH == 512
  const __m512i pressed = (__m512i)selected.pressed(v);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm512_maskz_cvtepi32_epi16(0xffff, pressed));
#elif MOTES_WIDTH == 256
  const auto pressed = (__m256i)selected.pressed(v);
  const __m256i narrow = _mm256_permute4x64_epi64(_mm256_packus_epi32(pressed, pressed), 0x08);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm256_castsi256_si128(narrow));
#elif MOTES_NEON
  vst1_u16(to, vmovn_u32((uint32x4_t)selected.pressed(v)));
#else
  for (std::size_t lane = 0; lane < kLanes; ++lane) to[selected.place(lane)] = static_cast<std::uint16_t>(v[lane]);
#endif
}

/// Writes the chosen lanes and returns their number; there must be room for all lanes.
MOTES_INLINE std::size_t squeeze(std::uint32_t* to, Uints v, Mask chosen) {
  const Selected selected(chosen);
  store_selected(to, selected, v);
  return selected.number();
}

}  // namespace motes::MOTES_ISA
