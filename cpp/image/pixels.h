// The pixels of a picture.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

namespace motes::image {

/// height * width * 3 bytes: red, green, blue in sRGB, rows from top to bottom. Unlike std::vector it does not clear
/// its memory, which would take as long as drawing a hundred thousand particles.
class Pixels {
 public:
  Pixels() = default;
  explicit Pixels(std::size_t size) { resize(size); }
  /// Uses memory that was allocated elsewhere.
  Pixels(std::shared_ptr<std::uint8_t[]> bytes, std::size_t size) : bytes_(std::move(bytes)), size_(size) {}
  /// Moved-from pixels are empty.
  Pixels(Pixels&& other) noexcept : bytes_(std::move(other.bytes_)), size_(std::exchange(other.size_, 0)) {}
  Pixels& operator=(Pixels&& other) noexcept {
    bytes_ = std::move(other.bytes_);
    size_ = std::exchange(other.size_, 0);
    return *this;
  }

  /// Changes the size; the content is then undefined. Does nothing if the size is the same.
  void resize(std::size_t size) {
    if (size == size_) return;
    bytes_ = std::make_unique_for_overwrite<std::uint8_t[]>(size);
    size_ = size;
  }
  std::size_t size() const { return size_; }
  std::uint8_t* data() { return bytes_.get(); }
  const std::uint8_t* data() const { return bytes_.get(); }
  std::uint8_t operator[](std::size_t i) const { return data()[i]; }
  std::uint8_t* begin() { return data(); }
  std::uint8_t* end() { return data() + size_; }
  const std::uint8_t* begin() const { return data(); }
  const std::uint8_t* end() const { return data() + size_; }

  friend bool operator==(const Pixels& a, const Pixels& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  std::shared_ptr<std::uint8_t[]> bytes_;
  std::size_t size_ = 0;
};

}  // namespace motes::image
