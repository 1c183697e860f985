// Values as bytes: the content of messages, recorded lists and scene files. Little-endian, no padding.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "base/memory.h"

namespace motes::base {

static_assert(std::endian::native == std::endian::little, "messages are little-endian");

/// A growing buffer. Unlike a vector it does not clear memory that is about to be overwritten.
class Bytes {
 public:
  Bytes() = default;
  /// A moved-from buffer is empty.
  Bytes(Bytes&& other) noexcept
      : data_(std::move(other.data_)), size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  Bytes& operator=(Bytes&& other) noexcept {
    data_ = std::move(other.data_);
    size_ = std::exchange(other.size_, 0);
    capacity_ = std::exchange(other.capacity_, 0);
    return *this;
  }

  /// Appends a number, or a struct of integers without padding; for other structs see base/fields.h.
  template <class T>
  void put(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::has_unique_object_representations_v<T>);
    static_assert(!std::is_pointer_v<T>);
    put_raw(&value, sizeof value);
  }
  void put_raw(const void* from, std::size_t count) {
    if (count != 0) std::memcpy(extend(count), from, count);
  }
  void put_text(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size()));
    put_raw(text.data(), text.size());
  }

  /// Makes room for `count` more bytes, which the caller fills.
  std::byte* extend(std::size_t count) {
    if (size_ + count > capacity_) grow(size_ + count);
    std::byte* start = data_.get() + size_;
    size_ += count;
    return start;
  }

  /// Overwrites bytes that were appended earlier.
  template <class T>
  void set(std::size_t at, const T& value) {
    std::memcpy(data_.get() + at, &value, sizeof value);
  }

  /// Reserves `size` bytes in total: appending up to that size does not reallocate.
  void reserve(std::size_t size) {
    if (size > capacity_) grow(size);
  }
  std::size_t capacity() const { return capacity_; }
  void clear() { size_ = 0; }
  void resize(std::size_t size) {
    if (size > capacity_) grow(size);
    size_ = size;
  }
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  std::byte* data() { return data_.get(); }
  const std::byte* data() const { return data_.get(); }
  std::span<const std::byte> view() const { return {data_.get(), size_}; }

 private:
  struct Free {
    void operator()(std::byte* p) const { std::free(p); }
  };

  static constexpr std::size_t kLeast = 64;  // a few small values do not reallocate each time

  void grow(std::size_t least) {
    std::size_t target = least > 2 * capacity_ ? least : 2 * capacity_;
    if (target < kLeast) target = kLeast;
    if (target >= kLargeMemory) return grow_large(target);
    void* wider = std::realloc(data_.get(), target);
    if (wider == nullptr) throw std::bad_alloc();
    (void)data_.release();
    data_.reset(static_cast<std::byte*>(wider));
    capacity_ = target;
  }
  void grow_large(std::size_t target) {
    std::unique_ptr<std::byte[], Free> wider(static_cast<std::byte*>(allocate(target)));
    if (size_ != 0) std::memcpy(wider.get(), data_.get(), size_);
    data_ = std::move(wider);
    capacity_ = target;
  }

  std::unique_ptr<std::byte[], Free> data_;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

/// Reads what Bytes wrote. Throws std::runtime_error if the bytes end too early.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    T value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string get_text() {
    const auto bytes = take(get<std::uint32_t>());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  std::span<const std::byte> take(std::size_t count) {
    if (count > rest_.size()) throw std::runtime_error("message or file ends too early");
    const auto front = rest_.first(count);
    rest_ = rest_.subspan(count);
    return front;
  }
  std::size_t left() const { return rest_.size(); }
  bool done() const { return rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
};

}  // namespace motes::base
