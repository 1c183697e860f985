// Tone mapping: from sums of light to values on a screen.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace motes::image {

/// Entries of the tone table: 2^kToneBits for each octave of light.
inline constexpr int kToneBits = 10;
inline constexpr int kToneEntries = 33 << kToneBits;

/// Returns the display value 0..1 (before sRGB) of linear light after exposure: unchanged up to a knee, then a shoulder
/// that reaches 1 only at infinity, so dense crowds of particles keep their contrast.
double roll_off(double light);

/// Returns sRGB for the whole range of a sum, in 1/256 of a byte's step, indexed by SplatLanes::tone.
std::vector<std::uint16_t> tone_table(double exposure);

/// The dither of 8-bit pictures: a pixel shows (value + threshold) >> 8. The threshold of column x in row y is the upper
/// byte of x * kDitherAcross + y * kDitherDown modulo 2^32, scaled to kLeastThreshold .. 256 - kLeastThreshold: a
/// sequence of low discrepancy (its steps are the powers of the plastic number), without visible lines. It depends only
/// on the place, so all ranks show the same; a value within kLeastThreshold of a whole byte is shown without dither, so
/// colours given in bytes stay flat.
inline constexpr std::uint32_t kDitherAcross = 3242174889u, kDitherDown = 2447445414u;
inline constexpr int kLeastThreshold = 13;

/// Returns linear light (before exposure) as 16-bit sRGB, 0..65535, by the same curve within one step. Values not above
/// 0, and NaN, become black.
std::vector<std::uint16_t> tone_16_bits(std::span<const float> light, double exposure);

}  // namespace motes::image
