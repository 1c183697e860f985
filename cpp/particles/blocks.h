// How many particles are processed at once.
#pragma once

#include <cstddef>

namespace motes::particles {

/// Particles are processed in blocks of at most this size. A block's columns stay in the L1 cache from one action to
/// the next.
inline constexpr std::size_t kBlock = 256;

/// The block size for lists of few actions. With short blocks all columns advance through memory side by side, which
/// the processor can prefetch; with still shorter ones, the overhead of starting the actions would grow. See
/// docs/lab/speed.md for figures.
inline constexpr std::size_t kShortBlock = 128;

/// Number of 32-bit words with one bit per particle of a block, plus a word for the padding behind it.
inline constexpr std::size_t kBlockWords = (kBlock + 31) / 32 + 1;

/// Planes can be read and written this far past the last particle: a vector of any width may start at the last one.
inline constexpr std::size_t kPadding = 16;

}  // namespace motes::particles
