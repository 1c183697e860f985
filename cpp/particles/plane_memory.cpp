#include "particles/plane_memory.h"

#include <cstdlib>
#include <utility>

#include "base/memory.h"

namespace motes::particles {
namespace {

// Bytes from which a plane gets huge pages, even if nothing else shares them.
constexpr std::size_t kWorthwhile = base::kLargeMemory / 2;

// Allocates memory and sets `bytes` to its size.
std::shared_ptr<std::byte[]> own_memory(std::size_t& bytes) {
  void* memory = base::allocate(bytes);
  return {static_cast<std::byte*>(memory), [](std::byte* own) { std::free(own); }};
}

}  // namespace

PlaneMemory::PlaneMemory(std::size_t bytes) {
  if (bytes >= kWorthwhile) open(bytes);
}

void PlaneMemory::open(std::size_t bytes) {
  size_ = bytes < base::kLargeMemory ? base::kLargeMemory : bytes;
  large_ = own_memory(size_);
  used_ = 0;
}

std::shared_ptr<std::byte[]> PlaneMemory::take(std::size_t bytes) {
  const std::size_t pages = base::whole_pages(bytes);
  if (pages > left()) {
    if (bytes < kWorthwhile) return own_memory(bytes);
    PlaneMemory next(pages);
    if (next.left() < left() + pages) return next.take(bytes);  // the old block has more room for others
    *this = std::move(next);
  }
  std::byte* piece = large_.get() + used_;
  used_ += pages;
  return {piece, [large = large_](std::byte*) {}};
}

}  // namespace motes::particles
