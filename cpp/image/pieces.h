// The records of a frame, sorted out by tile.
#pragma once

#include <cstddef>
#include <deque>
#include <span>
#include <vector>

#include "image/grid.h"
#include "image/records.h"
#include "image/splat_lanes.h"

namespace motes::image {

/// How the records of one message are drawn: worked out once per message and frame.
struct Brush {
  explicit Brush(const RecordsView& records);

  Sprite sprite;
  Grid grid;
  std::size_t record_bytes;
  Splat splat;
};

/// Records of one message for one tile. The order of pieces, and of records in them, has no meaning.
struct Piece {
  const Brush* brush;
  const std::byte* records;  // any alignment
  std::size_t count;
};

/// All messages of a frame, from any number of ranks.
class Pieces {
 public:
  /// Forgets the last frame's messages.
  void begin(const View& view);

  /// The bytes must not change while pieces of them are in use. Throws std::runtime_error where they are malformed or
  /// made for a different view.
  void add(std::span<const std::byte> message);

  /// Replaces the content of `pieces` by those of one tile; returns how many records they have. Pieces are valid until
  /// the next begin().
  std::size_t collect(int tile, std::vector<Piece>& pieces) const;

 private:
  struct Part {
    RecordsView records;
    Brush brush;
  };

  Grid grid_;
  bool with_depth_ = false;
  std::deque<Part> parts_;  // a deque: pieces point to brushes
};

}  // namespace motes::image
