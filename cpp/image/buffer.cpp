#include "image/buffer.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "base/memory.h"

namespace motes::image {

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

void Buffer::reserve(std::size_t size) {
  if (size <= capacity_) return;
  std::size_t capacity = std::max(size, capacity_ + capacity_ / 2);
  std::unique_ptr<std::byte[], Free> wider(static_cast<std::byte*>(base::allocate(capacity)));
  if (size_ != 0) std::memcpy(wider.get(), data_.get(), size_);
  data_ = std::move(wider);
  capacity_ = capacity;
}

void Buffer::resize(std::size_t size) {
  reserve(size);
  size_ = size;
}

}  // namespace motes::image
