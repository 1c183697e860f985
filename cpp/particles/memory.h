// Large memory without page faults for each 4 kB of it.
#pragma once

#include <cstddef>

namespace motes::particles {

/// From here on memory is worth huge pages.
inline constexpr std::size_t kLargeMemory = std::size_t{4} << 20;

/// At least `bytes` of memory for std::free, aligned to a cache line; from kLargeMemory on in huge pages, where the
/// kernel has them. Sets `bytes` to what there is. Throws std::bad_alloc.
void* allocate(std::size_t& bytes);

}  // namespace motes::particles
