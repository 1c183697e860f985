// The records of a frame, by tile.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "image/project/records.h"
#include "image/raster/brush.h"
#include "image/slots.h"

namespace motes::image {

/// Records of one message for one tile. The order of pieces, and of records in them, does not matter.
struct Piece {
  const Brush* brush;
  const std::byte* records;  // any alignment
  std::size_t count;
  std::uint8_t most_alpha = 255;  // greatest alpha of any record
  std::uint32_t color = 0;        // of all records, if they carry none: r | g << 8 | b << 16 | alpha << 24
};

/// Returns whether any piece blends so.
inline bool any(std::span<const Piece> pieces, Sprite::Blend blend) {
  return std::any_of(pieces.begin(), pieces.end(), [&](const Piece& p) { return p.brush->blends(blend); });
}

/// All messages with records of a frame, from any number of ranks.
class Pieces {
 public:
  /// Drops the last frame's messages. `slots`: the order of tiles in the messages.
  void begin(const View& view, const Slots& slots = {});

  /// Adds a message, whose bytes must not change while pieces of it are in use. Throws std::runtime_error if it is
  /// malformed or made for a different view.
  void add(std::span<const std::byte> message);

  /// Fills `pieces` with those of one tile and returns their number of records. Pieces are valid until the next
  /// begin().
  std::size_t collect(int tile, std::vector<Piece>& pieces) const;

  /// Calls use(brush) for the brushes of all messages, in any order.
  template <class Use>
  void each_brush(const Use& use) const {
    for (const Part& part : parts_) use(*part.brush);
  }

 private:
  struct Part {
    RecordsView records;
    const Brush* brush;
  };

  const Brush& brush_for(const RecordsView& records);

  View view_;
  Slots slots_;
  std::deque<Brush> brushes_;  // some of the last frame stay while the view does; a deque: pieces point to them
  std::vector<Part> parts_;
};

}  // namespace motes::image
