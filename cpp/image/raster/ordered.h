// Sorts the records of a tile from far to near, for blending by alpha.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "image/buffer.h"
#include "image/raster/pieces.h"

namespace motes::image {

/// Sorts non-opaque records by depth, farthest first. Ties are ordered by content (brush, then bytes), so the result
/// depends only on the set of records. Reuses its memory from tile to tile.
class Ordered {
 public:
  /// Records without a depth count as nearest. Throws std::runtime_error if some have no colour (see
  /// in_order_of_depth()). The pieces must not change while the result is in use.
  void sort(std::span<const Piece> pieces);

  /// Returns the sorted records as runs that share a brush, each contiguous in memory.
  std::span<const Piece> runs() const { return runs_; }

 private:
  struct Entry {
    const std::byte* record;
    const Brush* brush;
  };

  void list(const Piece& piece, std::size_t first, std::size_t at);
  void sort_keys();
  Entry entry(std::uint64_t key) const;
  bool begins_equals(std::size_t i, std::uint64_t before) const;
  void order_equals(std::size_t first);
  void gather();
  template <std::size_t kSize>
  void copy_alike(std::size_t size);
  void gather_each();

  // A key: complement of the depth's bits (upper half), index of the record (lower half).
  BufferOf<std::uint64_t> keys_, other_keys_;
  std::uint32_t least_ = 0, greatest_ = 0;  // range of the keys' upper halves
  std::size_t count_ = 0, bytes_ = 0;       // of all records
  std::uint8_t most_alpha_ = 0;
  const Brush* brush_ = nullptr;  // of all records; null: they have several
  Buffer listed_;                 // copies of all records, if they share a brush; otherwise entries_
  BufferOf<Entry> entries_;
  std::vector<Piece> runs_;
  Buffer records_;
};

}  // namespace motes::image
