#include "image/slots.h"

#include <stdexcept>
#include <string>
#include <utility>

namespace motes::image {

Slots::Slots(std::vector<std::uint32_t> tile_in_slot) : tiles_(std::move(tile_in_slot)) {
  constexpr std::uint32_t kNone = UINT32_MAX;
  slots_.assign(tiles_.size(), kNone);
  for (std::uint32_t slot = 0; slot < tiles_.size(); ++slot) {
    const std::uint32_t tile = tiles_[slot];
    if (tile >= tiles_.size() || slots_[tile] != kNone) {
      throw std::invalid_argument("slots must list each of " + std::to_string(tiles_.size()) + " tiles once: slot " +
                                  std::to_string(slot) + " has tile " + std::to_string(tile));
    }
    slots_[tile] = slot;
  }
}

}  // namespace motes::image
