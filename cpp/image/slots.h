// The order in which a message lists the tiles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "image/grid.h"

namespace motes::image {

/// A permutation of the tiles. If the tiles of each owner are in adjacent slots, an owner's part of a message is one
/// range of each batch. Empty: tile t is in slot t.
class Slots {
 public:
  Slots() = default;

  /// Takes the tile in each slot. Throws std::invalid_argument if a tile is missing or listed twice.
  explicit Slots(std::vector<std::uint32_t> tile_in_slot);

  /// Returns whether this is a permutation of `tiles` tiles; an empty one fits any number.
  bool fits(int tiles) const { return tiles_.empty() || tiles_.size() == static_cast<std::size_t>(tiles); }

  int tile(int slot) const { return tiles_.empty() ? slot : static_cast<int>(tiles_[static_cast<std::size_t>(slot)]); }
  int slot(int tile) const { return slots_.empty() ? tile : static_cast<int>(slots_[static_cast<std::size_t>(tile)]); }

 private:
  std::vector<std::uint32_t> tiles_;  // by slot
  std::vector<std::uint32_t> slots_;  // by tile
};

/// The order in which tiles are dealt out: row by row from the top, or column by column from the left.
enum class TileOrder : std::uint8_t { rows, columns };

/// Returns the tiles of a picture in this order.
Slots slots_of(TileOrder order, const Grid& grid);

}  // namespace motes::image
