// Records to light: the inner loops of the image generator, on one tile's sums.
#pragma once

#include <cstddef>
#include <cstdint>

namespace motes::image {

/// The sum that represents a linear value of 1: a record of full colour and alpha (4064) times a weight of 255. A sum
/// holds 4144 such records; with more it stays at its greatest value.
inline constexpr std::uint32_t kUnit = 4064 * 255;

/// The scenery's light is stored in units of 64 sums.
inline constexpr int kSceneryShift = 6;

/// Steps per octave in the index of the tone table: see tone().
inline constexpr int kToneBits = 8;
inline constexpr int kToneEntries = 33 << kToneBits;

/// A tile's sums, with a margin for footprints that extend over its edges: `stride` lanes per row, three lanes per
/// pixel. What falls into the margin is not read: the neighbouring tile has its own copy of the record.
struct TileSums {
  std::uint32_t* light;        // the tile's first pixel
  const std::uint32_t* depth;  // the same layout: bits of the scenery's depth, each three times; null: no scenery
  int stride;

  // Bits of the nearest and the farthest depth in the tile: a particle in front of or behind both needs no test per
  // pixel.
  std::uint32_t nearest, farthest;
};

/// How records of one sprite find their pixels.
struct Splat {
  const std::uint8_t* weights;  // see Footprint
  int size, phase_bits, row_bytes;
  int sub_bits;
  int origin_x, origin_y;  // fixed-point position of the particle whose footprint starts at the tile's first pixel
  bool with_depth;         // records of 12 bytes instead of 8
  bool saturating;         // the sums may overflow
};

struct SplatLanes {
  /// Adds `count` records.
  void (*splat)(const TileSums& sums, const Splat& splat, const unsigned char* records, std::size_t count);

  /// The greatest of the sums in `rows` rows of `lanes` lanes.
  std::uint32_t (*brightest)(const TileSums& sums, int rows, int lanes);

  /// light[i] = scenery[i] << kSceneryShift.
  void (*start)(std::uint32_t* light, const std::uint16_t* scenery, std::size_t count);

  /// to[i] = table[index of light[i]]: the index has 2^kToneBits steps per octave of light[i] / 2.
  void (*tone)(const std::uint32_t* light, std::size_t count, const std::uint8_t* table, std::uint8_t* to);
};

/// The build that suits this processor.
const SplatLanes& splat_lanes();

}  // namespace motes::image

namespace motes::sse2 {
extern const image::SplatLanes splat_lanes;
}
namespace motes::avx2 {
extern const image::SplatLanes splat_lanes;
}
namespace motes::avx512 {
extern const image::SplatLanes splat_lanes;
}
