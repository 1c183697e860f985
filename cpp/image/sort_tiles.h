// The records of projected particles, put behind one another by tile.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/grid.h"
#include "image/project_lanes.h"
#include "image/project_wide_lanes.h"

namespace motes::image {

/// Elements that `counts` and `cursor` below need: increments by 0 may go past the last tile.
constexpr std::size_t cursors(std::size_t tiles, std::size_t columns) { return tiles + columns + 2; }

/// Adds the records of each tile to `counts`, and lists the particles that touch several tiles in `several`, which has
/// room for all. Returns how many those are.
std::size_t count_fixed(const ProjectedBatch& batch, std::size_t count, std::size_t columns, std::uint32_t* counts,
                        std::uint32_t* several);

/// Writes each particle's record to the next place of each of its tiles: `cursor` says which, and is moved on.
void scatter_fixed(const ProjectedBatch& batch, std::size_t count, std::size_t columns, std::uint32_t* cursor,
                   const std::uint32_t* several, std::size_t listed, std::byte* records);

/// The same for records of the other layouts, which may touch any number of
/// tiles.
std::size_t count_wide(const WideBatch& batch, std::size_t count, Layout layout, const Grid& grid,
                       std::uint32_t* counts, std::uint32_t* several);
void scatter_wide(const WideBatch& batch, std::size_t count, Layout layout, const Grid& grid, std::uint32_t* cursor,
                  const std::uint32_t* several, std::size_t listed, std::byte* records);

} // namespace motes::image
