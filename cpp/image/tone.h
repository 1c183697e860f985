// From sums of light to what a screen shows.
#pragma once

#include <cstdint>
#include <vector>

namespace motes::image {

/// Display value 0..1 (before sRGB) of linear light that exposure has been applied to: itself up to a knee, then a
/// shoulder that reaches 1 only at infinity, so that where particles crowd the picture keeps its shape.
double roll_off(double light);

/// sRGB bytes by the index of SplatLanes::tone, for the whole range of a sum.
std::vector<std::uint8_t> tone_table(double exposure);

}  // namespace motes::image
