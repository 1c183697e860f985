#include "image/buffer.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace motes::image {
namespace {

constexpr std::size_t kHugePage = std::size_t{1} << 21;

}  // namespace

void Buffer::Free::operator()(std::byte* memory) const { std::free(memory); }

Buffer::Buffer(Buffer&& other) noexcept
    : data_(std::move(other.data_)), size_(std::exchange(other.size_, 0)),
      capacity_(std::exchange(other.capacity_, 0)) {}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
  data_ = std::move(other.data_);
  size_ = std::exchange(other.size_, 0);
  capacity_ = std::exchange(other.capacity_, 0);
  return *this;
}

void Buffer::resize(std::size_t size) {
  if (size > capacity_) {
    const std::size_t wanted = std::max(size, capacity_ + capacity_ / 2);
    const std::size_t align = wanted >= 2 * kHugePage ? kHugePage : 64;
    const std::size_t rounded = (wanted + align - 1) / align * align;
    std::unique_ptr<std::byte[], Free> wider(static_cast<std::byte*>(std::aligned_alloc(align, rounded)));
    if (wider == nullptr) throw std::bad_alloc();
#if defined(__linux__)
    if (align == kHugePage) madvise(wider.get(), rounded, MADV_HUGEPAGE);  // a hint: may be ignored
#endif
    if (size_ != 0) std::memcpy(wider.get(), data_.get(), size_);
    data_ = std::move(wider);
    capacity_ = rounded;
  }
  size_ = size;
}

}  // namespace motes::image
