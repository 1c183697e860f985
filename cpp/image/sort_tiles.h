// The records of projected particles, put behind one another by tile.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/project_lanes.h"
#include "image/project_wide_lanes.h"

namespace motes::image {

/// Elements that `counts` and `cursor` below need: increments by 0 may go past the last tile.
constexpr std::size_t cursors(std::size_t tiles, std::size_t columns) { return tiles + columns + 2; }

/// Particles whose records' memory is asked for at once, while they are counted: nobody waits for it then.
inline constexpr std::size_t kAskedAtOnce = 64;

/// A tile that a particle touches beside its first one.
struct FurtherTile {
  std::uint32_t particle, tile;
};
/// Particles that touch up to four tiles touch up to so many beside the first.
inline constexpr std::size_t kFurtherTiles = 3;

/// Lists those of a particle whose first tile is `tile`, and whose `word` has the flags kNextColumn, kNextRow or both;
/// there is room for one more than are listed. Returns the end of the list. Free of branches: which tiles particles
/// touch is random, and a misprediction costs more than an entry that the next one overwrites.
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

/// Adds the records of each tile to `counts`, and lists `further` tiles, for which there is room for kFurtherTiles of
/// each particle that touches several, and of one more. Returns how many are listed. Meanwhile it asks for the memory
/// where the particles' records of `record_bytes` will be written.
std::size_t count_fixed(const ProjectedBatch& batch, const ProjectedCount& number, std::size_t columns,
                        std::uint32_t* counts, FurtherTile* further, const std::byte* records,
                        std::size_t record_bytes);

/// Writes each particle's record to the next place of each of its tiles: `cursor` says which, and is moved on.
void scatter_fixed(const ProjectedBatch& batch, bool one_color, std::size_t count, std::uint32_t* cursor,
                   const FurtherTile* further, std::size_t listed, std::byte* records);

/// The same for records of the other layouts, which may touch any number of tiles: those of particles that touch many
/// are all among the `further` ones, whose memory grows. `several` has room for all particles.
std::size_t count_wide(const WideBatch& batch, std::size_t count, Layout layout, const Grid& grid,
                       std::uint32_t* counts, std::uint32_t* several, BufferOf<FurtherTile>& further,
                       const std::byte* records, std::size_t record_bytes);
void scatter_wide(const WideBatch& batch, std::size_t count, Layout layout, std::uint32_t* cursor,
                  const FurtherTile* further, std::size_t listed, std::byte* records);

}  // namespace motes::image
