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

/// A tile that a particle touches beside its first one.
struct FurtherTile {
  std::uint32_t particle, tile;
};
/// Particles of fixed size touch up to three.
inline constexpr std::size_t kFurtherTiles = 3;

/// Adds the records of each tile to `counts`, and lists `further` tiles, for which there is room for kFurtherTiles of
/// each particle that touches several, and of one more. Returns how many are listed.
std::size_t count_fixed(const ProjectedBatch& batch, const ProjectedCount& number, std::size_t columns,
                        std::uint32_t* counts, FurtherTile* further);

/// Writes each particle's record to the next place of each of its tiles: `cursor` says which, and is moved on.
void scatter_fixed(const ProjectedBatch& batch, std::size_t count, std::uint32_t* cursor, const FurtherTile* further,
                   std::size_t listed, std::byte* records);

/// The same for records of the other layouts, which may touch any number of tiles: those of particles that touch many
/// are all among the `further` ones, whose memory grows. `several` has room for all particles.
std::size_t count_wide(const WideBatch& batch, std::size_t count, Layout layout, const Grid& grid,
                       std::uint32_t* counts, std::uint32_t* several, BufferOf<FurtherTile>& further);
void scatter_wide(const WideBatch& batch, std::size_t count, Layout layout, std::uint32_t* cursor,
                  const FurtherTile* further, std::size_t listed, std::byte* records);

}  // namespace motes::image
