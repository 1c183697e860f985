#include "image/slots.h"

#include <string>
#include <utility>

#include "base/invalid_argument.h"

namespace motes::image {

Slots::Slots(std::vector<std::uint32_t> tile_in_slot) : tiles_(std::move(tile_in_slot)) {
  constexpr std::uint32_t kNone = UINT32_MAX;
  slots_.assign(tiles_.size(), kNone);
  for (std::uint32_t slot = 0; slot < tiles_.size(); ++slot) {
    const std::uint32_t tile = tiles_[slot];
    if (tile >= tiles_.size() || slots_[tile] != kNone) {
      throw base::InvalidArgument("slots", "list each of " + std::to_string(tiles_.size()) + " tiles once: slot " +
                                               std::to_string(slot) + " has tile " + std::to_string(tile));
    }
    slots_[tile] = slot;
  }
}

Slots slots_of(TileOrder order, const Grid& grid) {
  if (order == TileOrder::rows) return {};
  std::vector<std::uint32_t> tiles;
  for (int column = 0; column < grid.columns(); ++column) {
    for (int row = 0; row < grid.rows(); ++row) {
      tiles.push_back(static_cast<std::uint32_t>(row * grid.columns() + column));
    }
  }
  return Slots(std::move(tiles));
}

}  // namespace motes::image
