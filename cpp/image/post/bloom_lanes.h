// The inner loops of bloom, on rows of lanes (three per pixel or cell).
#pragma once

#include <cstddef>
#include <cstdint>

#include "simd/declare_builds.h"

namespace motes::image {

/// A symmetric filter of integers: taps[0] * lane + taps[k] * (the two lanes at distance k), divided by 2^16.
struct Taps {
  static constexpr int kMost = 12;
  static constexpr int kShift = 16;
  int reach = 0;  // greatest k
  std::uint64_t taps[kMost + 1] = {};
};

/// Where the lanes of a finer row lie in a row of cells: lane i is between lanes left[i] - first and right[i] - first,
/// at beyond[i] of the way, in 2^-kBits.
struct BetweenLanes {
  static constexpr int kBits = 16;
  const std::uint32_t* left;
  const std::uint32_t* right;
  const std::uint64_t* beyond;
  std::uint32_t first;
};

struct BloomLanes {
  /// sums[i] += light[i] * weight, for light of a picture, and of a finer level.
  void (*add)(std::uint64_t* sums, const std::uint32_t* light, std::uint32_t weight, std::size_t count);
  void (*add_cells)(std::uint64_t* sums, const std::uint64_t* light, std::uint32_t weight, std::size_t count);

  /// to[i] = the filter across rows[-reach] .. rows[reach], each of `count` lanes.
  void (*filter)(std::uint64_t* to, const std::uint64_t* const* rows, const Taps& taps, std::size_t count);

  /// to[i] = light of a row of cells at lane i, interpolated linearly between their centres.
  void (*widen)(std::uint64_t* to, const std::uint64_t* cells, const BetweenLanes& between, std::size_t count);

  /// glow[i] = near[i] * 2^kBits + (far[i] - near[i]) * beyond; step[i] = (far[i] - near[i]) * slope; all modulo 2^64.
  void (*start)(std::uint64_t* glow, std::uint64_t* step, const std::uint64_t* near, const std::uint64_t* far,
                std::uint64_t beyond, std::uint64_t slope, std::size_t count);

  /// light[i] = light[i] * (1 - part / 2^16) + glow[i] / 2^shift, rounded, at most 2^32 - 1; then glow[i] += step[i].
  void (*mix)(std::uint32_t* light, std::uint64_t* glow, const std::uint64_t* step, std::uint32_t part, int shift,
              std::size_t count);

  /// light[i] += glow[i] / 2^kBits; then glow[i] += step[i].
  void (*mix_cells)(std::uint64_t* light, std::uint64_t* glow, const std::uint64_t* step, std::size_t count);
};

/// Returns the build for this processor.
const BloomLanes& bloom_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::BloomLanes, bloom_lanes)
