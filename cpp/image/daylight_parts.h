// Where the light on solids and spheres comes from, as parts of full light.
#pragma once

namespace motes::image {

inline constexpr double kSun = 0.70;
inline constexpr double kSky = 0.24;    // from above
inline constexpr double kBounce = 0.10; // from below
inline constexpr double kTint = 0.5; // how much of the background's colour the sky adds

} // namespace motes::image
