// render, path composite: a calculator draws its own particles into partial tiles, which the ranks that own these tiles
// merge. Only additive particles where there are no others, or opaque ones: sums of sums are the same bits, and so is
// the nearest of the nearest. All others are blended by the owner, which has their records (see merged_blend).
#pragma once

#include <cstdint>

#include "frame/rank.h"
#include "frame/render.h"

namespace motes::frame {

/// Appends what this calculator's particles make of those tiles in slots first .. end - 1 that they touch: only those
/// of the blend that is merged. Returns how many records that stands for.
std::uint64_t put_partials(const Rank& rank, Painter& painter, int first, int end, particles::Bytes& out);

/// Partial tiles of one message, in the order of their slots.
class Partials {
 public:
  explicit Partials(particles::Reader in) : in_(in) { next(); }

  /// Merges what the message has of a tile into the painter's; returns how many records that stands for. Tiles must be
  /// asked for in the order of their slots.
  std::uint64_t add_to(int tile, image::TilePainter& painter);
  /// Whether the message has something of this tile.
  bool has(int tile) const { return tile_ == tile; }
  /// Throws std::runtime_error where something is left that no tile asked for.
  void check_done() const;

 private:
  void next();

  particles::Reader in_;
  int tile_ = -1;
  std::uint64_t records_ = 0;
  std::span<const std::byte> bytes_;
};

}  // namespace motes::frame
