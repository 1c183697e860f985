// Traces: earlier positions of particles at regular times, kept in their own attributes. These migrate, are
// checkpointed and count in digests like all attributes; systems without them pay nothing.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "particles/store.h"
#include "threads/pool.h"

namespace motes::particles {

/// Number of kept positions; the newest one replaces the oldest.
inline constexpr int kTraced = 16;

/// The attribute that counts a particle's kept positions. One attribute of three numbers per position follows it.
inline constexpr const char* kTraceCount = "ribbon_count";

/// The attribute that holds, in periodic space, `crossings` at the last update of the trace. Kept positions move with a
/// particle that wraps, so its trace stays connected.
inline constexpr const char* kTraceCrossings = "ribbon_crossings";

/// Returns the names and widths of all these attributes, in their order.
std::vector<std::pair<std::string, int>> trace_attributes(bool periodic);

/// The frames in which positions are kept.
struct TraceTimes {
  std::uint64_t frame = 0;
  std::uint64_t every = 1;  // frames from one position to the next

  /// Returns the times with which the kept positions always reach back `length` seconds.
  static TraceTimes over(double length, double dt, std::uint64_t frame);

  bool now() const { return frame % every == 0; }
  /// Returns the slot of the position that was kept `back` times ago, 0..kTraced - 1.
  int slot(int back) const {
    return static_cast<int>((frame / every + kTraced - static_cast<std::uint64_t>(back)) % kTraced);
  }
  /// Returns the frames since that position was kept.
  std::uint64_t age(int back) const { return frame % every + static_cast<std::uint64_t>(back) * every; }
};

/// Keeps the positions of all particles if it is time, else of those that have none yet. Does nothing if the schema has
/// no kTraceCount.
void keep_trace(Store& store, const TraceTimes& times, threads::Pool& pool = threads::alone());

}  // namespace motes::particles
