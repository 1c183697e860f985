// How many particles are processed at once.
#pragma once

#include <cstddef>

namespace motes::particles {

/// Particles are processed in blocks of this size, so that a block's columns stay in the first-level cache.
inline constexpr std::size_t kBlock = 512;

/// Planes can be read and written this far past the last particle: a vector of any width may start at the last one.
inline constexpr std::size_t kPadding = 16;

}  // namespace motes::particles
