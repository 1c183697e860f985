// The timeline of this rank: one row per phase and round.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "jsonl/table.h"

namespace motes::engine {

/// Collects rows for this rank's file. Times count from `zero`, the same moment on all ranks up to message latency.
class Spans {
 public:
  /// Appends after the rows of frames before `first_frame` if that is above 0. Throws std::runtime_error, naming the
  /// path, if it cannot write.
  Spans(const std::string& directory, int rank, double zero, std::uint64_t first_frame);

  /// Adds a row for a phase. `system`: its name, or empty for all. `cpu_s`: processor time of the rank's thread; none
  /// if phases overlap.
  void add(std::uint64_t frame, const char* phase, const std::string& system, double start, double end,
           std::optional<double> cpu_s);
  /// Adds a row for a wait for a message of `phase` from `rank`; -1: from several ranks.
  void add_wait(std::uint64_t frame, const char* phase, int rank, double start, double end);
  void write() { table_.write(); }

 private:
  jsonl::JsonlTable table_;
  double zero_;
};

}  // namespace motes::engine
