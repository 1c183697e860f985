// From sums of light to the values that a screen shows.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace motes::image {

/// Entries of the tone table: 2^kToneBits for each octave of light.
inline constexpr int kToneBits = 8;
inline constexpr int kToneEntries = 33 << kToneBits;

/// Display value 0..1 (before sRGB) of linear light after exposure: unchanged up to a knee, then a shoulder that
/// reaches 1 only at infinity, so that dense crowds of particles keep their contrast.
double roll_off(double light);

/// sRGB bytes, indexed by SplatLanes::tone, for the whole range of a sum.
std::vector<std::uint8_t> tone_table(double exposure);

/// The same curve with 16 bits: linear light before exposure to sRGB in 0..65535, within one step. What is not above 0,
/// NaN too, is black.
std::vector<std::uint16_t> tone_16_bits(std::span<const float> light, double exposure);

}  // namespace motes::image
