// How many particles are processed at once.
#pragma once

#include <cstddef>

namespace motes::particles {

/// Particles are processed in blocks of at most this size. A block's columns stay in the first-level cache from one
/// action to the next.
inline constexpr std::size_t kBlock = 256;

/// Of a list of few actions. Blocks are short, so that all columns advance through memory side by side, which the
/// processor foresees; with still shorter ones, starting the actions would cost more. docs/notes/speed.md has figures.
inline constexpr std::size_t kShortBlock = 128;

/// Words that have a bit for each particle of a block, and for the padding behind it.
inline constexpr std::size_t kBlockWords = (kBlock + 31) / 32 + 1;

/// Planes can be read and written this far past the last particle: a vector of any width may start at the last one.
inline constexpr std::size_t kPadding = 16;

}  // namespace motes::particles
