#include "base/memory.h"

#include <algorithm>
#include <cstdlib>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace motes::base {
namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kCacheLine = 64;

}  // namespace

void* allocate(std::size_t& bytes) {
  const std::size_t align = bytes >= kLargeMemory ? kHugePage : kCacheLine;
  const std::size_t rounded = std::max((bytes + align - 1) / align * align, align);
  void* memory = std::aligned_alloc(align, rounded);
  if (memory == nullptr) throw std::bad_alloc();
#if defined(__linux__)
  if (align == kHugePage) madvise(memory, rounded, MADV_HUGEPAGE);  // a hint: a kernel without them ignores it
#endif
  bytes = rounded;
  return memory;
}

}  // namespace motes::base
