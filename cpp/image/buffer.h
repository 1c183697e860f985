// A large buffer that is filled again in each frame.
#pragma once

#include <cstddef>
#include <memory>

namespace motes::image {

/// A growing array of bytes, aligned to a cache line. Unlike std::vector it does not clear memory that is about to be
/// overwritten. It asks for huge pages from a few megabytes on, and keeps its memory when it shrinks, so frames after
/// the first cause no page faults.
class Buffer {
 public:
  Buffer() = default;
  /// A moved-from buffer is empty.
  Buffer(Buffer&& other) noexcept;
  Buffer& operator=(Buffer&& other) noexcept;

  std::size_t size() const { return size_; }
  std::byte* data() { return data_.get(); }
  const std::byte* data() const { return data_.get(); }

  /// Changes the size and keeps the content; new bytes are undefined. Invalidates pointers if the capacity grows.
  void resize(std::size_t size);
  /// Makes room for `size` bytes: resize() up to this size will not move the content.
  void reserve(std::size_t size);

 private:
  struct Free {
    void operator()(std::byte* memory) const;
  };

  std::unique_ptr<std::byte[], Free> data_;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

/// A Buffer of T instead of bytes.
template <class T>
class BufferOf {
 public:
  void resize(std::size_t count) { bytes_.resize(count * sizeof(T)); }
  std::size_t size() const { return bytes_.size() / sizeof(T); }
  T* data() { return reinterpret_cast<T*>(bytes_.data()); }
  const T* data() const { return reinterpret_cast<const T*>(bytes_.data()); }

 private:
  Buffer bytes_;
};

}  // namespace motes::image
