// When this rank did what: one line per phase and round, for timelines.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "jsonl/table.h"

namespace motes::engine {

/// Each rank writes a file of its own, once per frame. Times count from `zero`, a moment that all ranks share as nearly
/// as messages allow.
class Spans {
 public:
  /// Goes on behind the rows of frames before `first_frame`, where that is above 0. Throws std::runtime_error, naming
  /// the path, where it cannot write.
  Spans(const std::string& directory, int rank, double zero, std::uint64_t first_frame);

  /// `system`: its name, or empty for all. `cpu_s`: processor time of the rank's thread; none where phases overlap.
  void add(std::uint64_t frame, const char* phase, const std::string& system, double start, double end,
           std::optional<double> cpu_s);
  /// This rank waited for a message of `phase` from `rank`; -1: from several.
  void add_wait(std::uint64_t frame, const char* phase, int rank, double start, double end);
  void write() { table_.write(); }

 private:
  jsonl::JsonlTable table_;
  double zero_;
};

}  // namespace motes::engine
