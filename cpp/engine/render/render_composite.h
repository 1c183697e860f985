// render, path composite: calculators draw their own particles into partial tiles, which the tiles' owners merge. This
// works for additive particles if there are no others, or for opaque ones: sums and nearest depths are the same bits in
// any order. All other particles are sent as records and blended by the owner (see merged_blend).
#pragma once

#include <cstdint>

#include "engine/render/render.h"
#include "engine/session/rank.h"

namespace motes::engine {

/// Draws this calculator's particles of the merged blend into partial tiles, for the slots from `first` to `end` - 1
/// that they touch, and appends these. Returns how many records they contain.
std::uint64_t put_partials(const Rank& rank, Painter& painter, int first, int end, base::Bytes& out);

/// Partial tiles of one message, for slots first .. end - 1. Threads may access different tiles concurrently.
class Partials {
 public:
  /// Throws std::runtime_error if the message has a tile outside these slots, or the same tile twice.
  Partials(base::Reader in, const Painter& painter, int first, int end);

  /// Merges the message's partial tile, if any, into the painter's tile; returns how many records it contains.
  std::uint64_t add_to(int slot, image::TilePainter& painter) const;
  /// Returns whether the message has a partial tile for this slot.
  bool has(int slot) const { return !of(slot).bytes.empty(); }

 private:
  struct Partial {
    std::uint64_t records = 0;
    std::span<const std::byte> bytes;
  };
  const Partial& of(int slot) const { return partials_[static_cast<std::size_t>(slot - first_)]; }

  int first_;
  std::vector<Partial> partials_;  // by slot
};

}  // namespace motes::engine
