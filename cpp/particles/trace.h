// Where a particle has been: positions at regular times, in attributes of its own. They travel, are checkpointed and
// count in digests as all attributes do; systems without these attributes pay nothing.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "particles/store.h"
#include "threads/pool.h"

namespace motes::particles {

/// Positions that are kept; the newest one replaces the oldest.
inline constexpr int kTraced = 16;

/// The attribute that counts a particle's kept positions. One attribute for each of them, of three numbers, follows it.
inline constexpr const char* kTraceCount = "ribbon_count";

/// In periodic space: the attribute `crossings` when the trace was last written. Kept positions move with a particle
/// that wraps, so that its trace stays whole.
inline constexpr const char* kTraceCrossings = "ribbon_crossings";

/// Names and widths of all these attributes, in their order.
std::vector<std::pair<std::string, int>> trace_attributes(bool periodic);

/// In which frames positions are kept.
struct TraceTimes {
  std::uint64_t frame = 0;
  std::uint64_t every = 1;  // frames from one position to the next

  /// Every how many frames a position is kept, so that all of them reach back `length` seconds at any time.
  static TraceTimes over(double length, double dt, std::uint64_t frame);

  bool now() const { return frame % every == 0; }
  /// The attribute that holds the position of `back` times before, 0..kTraced - 1.
  int slot(int back) const {
    return static_cast<int>((frame / every + kTraced - static_cast<std::uint64_t>(back)) % kTraced);
  }
  /// Frames since then.
  std::uint64_t age(int back) const { return frame % every + static_cast<std::uint64_t>(back) * every; }
};

/// Keeps the positions of all particles, where it is time, and those of particles that have none yet. Does nothing
/// where the schema has no kTraceCount.
void keep_trace(Store& store, const TraceTimes& times, threads::Pool& pool = threads::alone());

}  // namespace motes::particles
