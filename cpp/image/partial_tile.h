// A tile's sums as a message: what several ranks drew of one tile is added up by the rank that owns it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "image/buffer.h"
#include "image/grid.h"

namespace motes::image {

/// Appends the sums of the smallest rectangle that holds every pixel with light:
///   magic u32, tile u32, left, top, right, bottom u8 (pixels of the tile), zero u32, sums u32[rows][columns][3]
/// `light` is the tile's first pixel, three sums per pixel, `stride` sums per row.
void append_partial(const Area& area, const std::uint32_t* light, int stride, Buffer& to);

/// Adds them; a sum that would overflow gets its greatest value, so that the order of partial tiles has no meaning.
/// Throws std::runtime_error where the bytes are not a whole partial tile of this area.
void add_partial(std::span<const std::byte> partial, const Area& area, std::uint32_t* light, int stride);

}  // namespace motes::image
