// From sums of light to the values that a screen shows.
#pragma once

#include <cstdint>
#include <vector>

namespace motes::image {

/// Display value 0..1 (before sRGB) of linear light after exposure: unchanged up to a knee, then a shoulder that
/// reaches 1 only at infinity, so that dense crowds of particles keep their contrast.
double roll_off(double light);

/// sRGB bytes, indexed by SplatLanes::tone, for the whole range of a sum.
std::vector<std::uint8_t> tone_table(double exposure);

}  // namespace motes::image
