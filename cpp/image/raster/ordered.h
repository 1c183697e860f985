// Records of a tile from far to near.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "image/buffer.h"
#include "image/raster/pieces.h"

namespace motes::image {

/// Sorts the records that are not opaque by depth, the farthest first. Equally deep ones are in the order of their
/// content (brush, then bytes), so the order depends only on the set of records. Keeps its memory from tile to tile.
class Ordered {
 public:
  /// Records without a depth are nearer than all others. Throws std::runtime_error where some have no colour: see
  /// in_order_of_depth(). The pieces must not change while the order is in use.
  void sort(std::span<const Piece> pieces);

  /// Neighbours that share a brush, one behind the other in memory; in order.
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

  // A key is the complement of the depth, then the number of the record.
  BufferOf<std::uint64_t> keys_, other_keys_;
  std::uint32_t least_ = 0, greatest_ = 0;  // complements of depths
  std::size_t count_ = 0, bytes_ = 0;       // of all records
  std::uint8_t most_alpha_ = 0;
  const Brush* brush_ = nullptr;  // of all records; null: they have several
  Buffer listed_;                 // all records, where they have one brush; else:
  BufferOf<Entry> entries_;
  std::vector<Piece> runs_;
  Buffer records_;
};

}  // namespace motes::image
