// Large memory without page faults for each 4 kB of it, and memory that is about to be written.
#pragma once

#include <cstddef>

namespace motes::base {

/// Memory in whole pages of the usual size.
inline constexpr std::size_t kPage = 4096;
constexpr std::size_t whole_pages(std::size_t bytes) { return (bytes + kPage - 1) / kPage * kPage; }

/// From here on memory is worth huge pages.
inline constexpr std::size_t kLargeMemory = std::size_t{1} << 20;

/// At least `bytes` of memory for std::free, aligned to a cache line; from kLargeMemory on in huge pages, where the
/// kernel has them. Sets `bytes` to what there is. Throws std::bad_alloc.
void* allocate(std::size_t& bytes);

/// Asks for memory that is about to be written: in random order, or in rows too far apart for the processor's guesses.
inline void prefetch_for_write(const void* from, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; i += 64) __builtin_prefetch(static_cast<const char*>(from) + i, 1);
}

}  // namespace motes::base
