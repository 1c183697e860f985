// Memory of a store's planes.
#pragma once

#include <cstddef>
#include <memory>

namespace motes::particles {

/// Deals out pieces of larger memory, so that planes which are too short for huge pages of their own share them: in
/// pages of 4 kB a step over 200,000 particles takes 1.25 times as long. What has been dealt out is given back as a
/// whole, when nobody holds any of it.
class PlaneMemory {
 public:
  PlaneMemory() = default;
  /// With room for so many bytes of planes, each rounded up to whole pages.
  explicit PlaneMemory(std::size_t bytes);
  /// A copy deals out memory of its own.
  PlaneMemory(const PlaneMemory&) {}
  PlaneMemory& operator=(const PlaneMemory& other) { return this == &other ? *this : *this = PlaneMemory(); }
  PlaneMemory(PlaneMemory&&) noexcept = default;
  PlaneMemory& operator=(PlaneMemory&&) noexcept = default;
  ~PlaneMemory() = default;

  /// At the start of a page, or, where there is no larger memory to share, on a cache line. Its content is undefined.
  std::shared_ptr<std::byte[]> take(std::size_t bytes);

 private:
  std::size_t left() const { return large_ ? size_ - used_ : 0; }
  void open(std::size_t bytes);

  std::shared_ptr<std::byte[]> large_;  // what is dealt out now; null: nothing
  std::size_t size_ = 0;
  std::size_t used_ = 0;
};

}  // namespace motes::particles
