// Tone mapping: from sums of light to values on a screen.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace motes::image {

/// Entries of the tone table: 2^kToneBits for each octave of light.
inline constexpr int kToneBits = 8;
inline constexpr int kToneEntries = 33 << kToneBits;

/// Returns the display value 0..1 (before sRGB) of linear light after exposure: unchanged up to a knee, then a shoulder
/// that reaches 1 only at infinity, so dense crowds of particles keep their contrast.
double roll_off(double light);

/// Returns sRGB bytes for the whole range of a sum, indexed by SplatLanes::tone.
std::vector<std::uint8_t> tone_table(double exposure);

/// Returns linear light (before exposure) as 16-bit sRGB, 0..65535, by the same curve within one step. Values not above
/// 0, and NaN, become black.
std::vector<std::uint16_t> tone_16_bits(std::span<const float> light, double exposure);

}  // namespace motes::image
