// Records near the surfaces of a tile. Found without branches: the depths of neighbouring records have nothing to do
// with each other.
#pragma once

#include "image/raster/point_lanes.h"
#include "image/raster/splat_lanes.h"
#include "simd/squeeze.h"

namespace motes::MOTES_ISA {

// Positions and depths of records that have sizes. Wide ones' positions are cut to half pixels; the depths of those
// that are too large for the bands become NaN, which is in each of them.
MOTES_INLINE void read_sized_places(const image::BandSearch& s, const unsigned char* records, std::size_t count,
                                    std::uint32_t* positions, std::uint32_t* depths) {
  const auto half_pixels = [](std::uint32_t at) {
    const int halves = static_cast<std::int32_t>(at) >> (image::kWideBits - 1);
    return static_cast<std::uint32_t>(halves < -32768 ? -32768 : halves > 32767 ? 32767 : halves) & 0xffffu;
  };
  const bool wide = image::is_wide(s.layout);
  for (std::size_t i = 0; i < count; ++i, records += s.record_bytes) {
    positions[i] = word_at(records);
    if (wide) positions[i] = half_pixels(positions[i]) | half_pixels(word_at(records + 4)) << 16;
    const auto size = static_cast<int>(word_at(records + s.form.size) & 0xffffu);
    depths[i] = size > s.most_size ? 0x7fc00000u : word_at(records + s.form.depth);
  }
}

MOTES_INLINE Mask in_band(const image::BandSearch& s, Uints positions, Uints depths) {
  const Ints x = (Ints)(positions << 16) >> 16, y = (Ints)positions >> 16;
  const Ints zero{};
  const Ints column = min_ints(max_ints((x + x + s.first_column) >> s.shift, zero), all_ints(s.last_column));
  const Ints row = min_ints(max_ints((y + y + s.first_row) >> s.shift, zero), all_ints(s.last_row));
  const Ints at = row * image::kTile + column;
  const Pair band = gather_pairs(&s.bands->low, at + at);
  const Floats depth = (Floats)depths;
  return ~((Mask)(depth < band.first) | (Mask)(depth >= band.second));
}

// Writes the numbers of those in their bands, and up to kLanes numbers without meaning behind them; returns how many.
MOTES_INLINE std::size_t find_in_bands(const image::BandSearch& search, const unsigned char* records, std::size_t count,
                                       std::uint32_t* to) {
  constexpr std::size_t kMost = 128;
  alignas(64) std::uint32_t position[kMost] = {}, depth[kMost] = {};
  const image::BandSearch s = search;
  const bool fixed = image::of_fixed_size(s.layout);
  std::size_t found = 0;
  for (std::size_t first = 0; first < count;
       first += kMost, records += kMost * static_cast<std::size_t>(s.record_bytes)) {
    const std::size_t number = count - first < kMost ? count - first : kMost;
    if (fixed) {
      read_places(s.record_bytes, s.form.depth, records, number, position, depth);
    } else {
      read_sized_places(s, records, number, position, depth);
    }
    for (std::size_t i = 0; i < number; i += kLanes) {
      const Mask chosen = in_band(s, load_uints(position + i), load_uints(depth + i)) & first_lanes(number - i);
      found += squeeze(to + found, lane_numbers() + static_cast<std::uint32_t>(first + i), chosen);
    }
  }
  return found;
}

}  // namespace motes::MOTES_ISA
