// render, path composite: a calculator draws its own particles into partial tiles, which the ranks that own these tiles
// merge. Only additive particles where there are no others, or opaque ones: sums of sums are the same bits, and so is
// the nearest of the nearest. All others are blended by the owner, which has their records (see merged_blend).
#pragma once

#include <cstdint>

#include "engine/render/render.h"
#include "engine/session/rank.h"

namespace motes::engine {

/// Appends what this calculator's particles make of those tiles in slots first .. end - 1 that they touch: only those
/// of the blend that is merged. Returns how many records that stands for.
std::uint64_t put_partials(const Rank& rank, Painter& painter, int first, int end, base::Bytes& out);

/// Partial tiles of one message, for the slots first .. end - 1. Threads may ask for different tiles at the same time.
class Partials {
 public:
  /// Throws std::runtime_error where the message has a tile that is in none of these slots, or twice the same.
  Partials(base::Reader in, const Painter& painter, int first, int end);

  /// Merges what the message has of a tile into the painter's; returns how many records that stands for.
  std::uint64_t add_to(int slot, image::TilePainter& painter) const;
  /// Tells whether the message has a part of this tile.
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
