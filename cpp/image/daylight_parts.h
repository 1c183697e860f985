// The light on solids and spheres by its source, as fractions of full light.
#pragma once

namespace motes::image {

inline constexpr double kSun = 0.70;
inline constexpr double kSky = 0.24;    // from above
inline constexpr double kBounce = 0.10; // from below
inline constexpr double kTint = 0.5; // factor on the background's colour, added to the sky's light

} // namespace motes::image
