// Memory of a store's planes.
#pragma once

#include <cstddef>
#include <memory>

namespace motes::particles {

/// Allocates planes from larger blocks of memory, so planes too short for their own huge pages share them: with pages
/// of 4 kB, a step over 200,000 particles takes 1.25 times as long. A block is freed as a whole, when none of its
/// planes is held any more.
class PlaneMemory {
 public:
  PlaneMemory() = default;
  /// Reserves room for this many bytes of planes, each rounded up to whole pages.
  explicit PlaneMemory(std::size_t bytes);
  /// A copy allocates from its own memory.
  PlaneMemory(const PlaneMemory&) {}
  PlaneMemory& operator=(const PlaneMemory& other) { return this == &other ? *this : *this = PlaneMemory(); }
  PlaneMemory(PlaneMemory&&) noexcept = default;
  PlaneMemory& operator=(PlaneMemory&&) noexcept = default;
  ~PlaneMemory() = default;

  /// Returns memory that starts on a page or, if there is no block to share, on a cache line. Its content is undefined.
  std::shared_ptr<std::byte[]> take(std::size_t bytes);

 private:
  std::size_t left() const { return large_ ? size_ - used_ : 0; }
  void open(std::size_t bytes);

  std::shared_ptr<std::byte[]> large_;  // the current block; null: none
  std::size_t size_ = 0;
  std::size_t used_ = 0;
};

}  // namespace motes::particles
