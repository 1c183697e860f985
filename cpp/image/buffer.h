// Large memory that is written front to back, frame after frame.
#pragma once

#include <cstddef>
#include <memory>

namespace motes::image {

/// A growing array of bytes, aligned to a cache line. Unlike a vector it does not clear memory that is about to be
/// overwritten. From a few megabytes on it asks for huge pages, and it keeps its memory when it shrinks, so frames
/// after the first cause no page faults.
class Buffer {
 public:
  Buffer() = default;
  /// A moved-from buffer is empty.
  Buffer(Buffer&& other) noexcept;
  Buffer& operator=(Buffer&& other) noexcept;

  std::size_t size() const { return size_; }
  std::byte* data() { return data_.get(); }
  const std::byte* data() const { return data_.get(); }

  /// Keeps the content; new bytes are undefined. Pointers become invalid where the capacity was too small.
  void resize(std::size_t size);
  /// Makes room for so many bytes: up to there resize() will move nothing.
  void reserve(std::size_t size);

 private:
  struct Free {
    void operator()(std::byte* memory) const;
  };

  std::unique_ptr<std::byte[], Free> data_;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

/// The same as an array of T, for the few places that need one.
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
