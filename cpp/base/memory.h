// Allocates large memory in huge pages, to save page faults; prefetches memory for writing.
#pragma once

#include <cstddef>

namespace motes::base {

/// Size of a page in bytes; whole_pages() rounds up to it.
inline constexpr std::size_t kPage = 4096;
constexpr std::size_t whole_pages(std::size_t bytes) { return (bytes + kPage - 1) / kPage * kPage; }

/// Allocations of at least this many bytes get huge pages.
inline constexpr std::size_t kLargeMemory = std::size_t{1} << 20;

/// Allocates at least `bytes`, aligned to a cache line, or to huge pages from kLargeMemory on if the kernel has them.
/// Sets `bytes` to the allocated size; release the memory with std::free. Throws std::bad_alloc.
void* allocate(std::size_t& bytes);

/// Prefetches memory where the hardware prefetcher cannot: in random order, or in rows far apart. Always inlined: GCC
/// removes calls of a function that does nothing but prefetch, as if it had no effect.
template <bool kForWrite = false>
[[gnu::always_inline]] inline void prefetch(const void* from, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; i += 64) __builtin_prefetch(static_cast<const char*>(from) + i, kForWrite);
}
[[gnu::always_inline]] inline void prefetch_for_write(const void* from, std::size_t bytes) {
  prefetch<true>(from, bytes);
}

}  // namespace motes::base
