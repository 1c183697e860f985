// How many particles are processed at once.
#pragma once

#include <cstddef>

namespace motes::particles {

/// Particles are processed in blocks of this many, so that a block's columns stay in the first cache.
inline constexpr std::size_t kBlock = 512;

/// Planes are readable and writable this far behind the last particle: a vector of any width may begin at it.
inline constexpr std::size_t kPadding = 16;

}  // namespace motes::particles
