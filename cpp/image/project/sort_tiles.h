// Sorts the records of projected particles by tile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/project/project_lanes.h"
#include "image/project/project_wide_lanes.h"

namespace motes::image {

/// Number of particles whose records' memory is prefetched at once, while they are counted.
inline constexpr std::size_t kAskedAtOnce = 64;

/// A tile that a particle touches besides its first one.
struct FurtherTile {
  std::uint32_t particle, tile;
};
/// Greatest number of further tiles of a particle that touches up to four tiles.
inline constexpr std::size_t kFurtherTiles = 3;

/// Lists the further tiles of a particle whose first tile is `tile` and whose `word` has the flags kNextColumn,
/// kNextRow or both; returns the end of the list. `to` has room for one extra entry. It has no branches: which tiles
/// particles touch is random, and a misprediction costs more than an entry that the next one overwrites.
inline FurtherTile* list_further(FurtherTile* to, std::uint32_t particle, std::uint32_t tile, std::uint32_t word,
                                 std::uint32_t columns) {
  static_assert(kNextColumn == 1u << 30 && kNextRow == 1u << 31);
  const std::uint32_t column = word >> 30 & 1, row = word >> 31;
  *to = {particle, tile + 1};
  to += column;
  *to = {particle, tile + columns};
  to += row;
  *to = {particle, tile + columns + 1};
  return to + (column & row);
}

/// A growing list of further tiles.
class FurtherTiles {
 public:
  /// Empties the list, and makes room for those of `several` particles that touch up to four tiles.
  void clear(std::size_t several) {
    size_ = 0;
    list_.resize(kFurtherTiles * (several + 1));
  }
  void add_up_to_three(std::uint32_t particle, std::uint32_t tile, std::uint32_t word, std::uint32_t columns) {
    FurtherTile* const end = list_.data() + size_;
    size_ += static_cast<std::size_t>(list_further(end, particle, tile, word, columns) - end);
  }
  /// Adds a tile of any particle. add_up_to_three() must not be called after this.
  void add(std::uint32_t particle, std::size_t tile) {
    if (size_ == list_.size()) list_.resize(2 * size_);
    list_.data()[size_++] = {particle, static_cast<std::uint32_t>(tile)};
  }
  std::span<const FurtherTile> all() const { return {list_.data(), size_}; }

 private:
  BufferOf<FurtherTile> list_;
  std::size_t size_ = 0;
};

/// The particles to count: the first tile of each of `visible` particles, and the particles that touch several.
struct Touched {
  const std::uint16_t* tile;
  const std::uint32_t* several;
  std::size_t visible, several_count;
  std::size_t columns;  // of tiles
};

/// Adds the number of records of each tile to `counts`, and lists further tiles. Meanwhile it prefetches the memory
/// where the particles' records, of `record_bytes` each, will be written.
void count_tiles(const Touched& touched, std::uint32_t* counts, FurtherTiles& further, const std::byte* records,
                 std::size_t record_bytes);

/// Adds the records of particles that touch many tiles to `counts`, and lists their further tiles.
void count_many(const WideBatch& batch, std::size_t many, const RecordForm& form, const Grid& grid,
                std::uint32_t* counts, FurtherTiles& further);

/// The colours of records: none, that of the first particle for all, or each its own.
enum class Colors { none, same, each };

/// Write the record of each particle to all of its tiles. `cursor`: the index of each tile's next record; it advances.
void scatter_fixed(const ProjectedBatch& batch, Colors colors, std::size_t count, std::uint32_t* cursor,
                   std::span<const FurtherTile> further, std::byte* records);
void scatter_wide(const WideBatch& batch, std::size_t count, std::size_t words, std::uint32_t* cursor,
                  std::span<const FurtherTile> further, std::byte* records);

}  // namespace motes::image
