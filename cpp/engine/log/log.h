// The run's log: small tables of JSON lines, one schema per file, written by the manager.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "balance/load.h"
#include "domains/domains.h"
#include "engine/session/links.h"
#include "engine/session/report.h"
#include "jsonl/table.h"

namespace motes::engine {

/// A row of load.jsonl: one system on one calculator in one frame.
struct LoadRow {
  std::string system;
  int rank = 0;
  Tally tally;
  std::uint64_t children = 0;  // born at the frame's end, so they took no time
  std::uint64_t n_end = 0;
  double rescaled_s = 0, exchange_s = 0, wait_s = 0, image_s = 0, project_s = 0;
  domains::Box domain;  // metres; infinite at the ends of space
  domains::Axes axes;   // axes that are cut
  double speed = 0;                    // particles per second
  Density density;
  float pack_s = 0, unpack_s = 0, search_s = 0;  // see CalculatorTail, like the next two
  double migrant_bytes = 0;
  std::array<float, kWays> ways{};
  InteractionStats interaction;
};

/// A row of balance.jsonl: a cut that a policy evaluated.
struct BalanceRow {
  std::uint64_t frame = 0;
  std::string system;
  int left_rank = 0, right_rank = 0;
  balance::Load left, right;
  std::optional<std::int64_t> ordered, given;  // particles; above 0: from left to right
  int axis = 0;                                // axis of the cut: 0..2, or kById
  float cut_before = 0, cut_after = 0;         // metres
  std::string policy;
};

/// A row of walls.jsonl: mean force, N, and torque, N m, of all particles on a wall in a frame.
struct WallRow {
  std::string shape;  // its kind
  std::array<double, 6> force;
};

/// A row of frames.jsonl.
struct FrameRow {
  std::uint64_t frame = 0;
  double time = 0;  // seconds of the animation
  std::uint64_t particles = 0, exchanged = 0, exchanged_bytes = 0, dropped = 0;
  double imbalance = 1;  // slowest calculator's compute seconds / their mean
  int slowest_rank = 0;
  PhaseTimes times;      // the slowest rank of each phase
  std::string births_by;    // empty: no births
  std::string render_path;  // empty: no picture
  std::uint64_t records = 0, record_bytes = 0, render_bytes = 0;
  std::string image_sha256;
  std::vector<particles::Digest> digests;  // one per system; empty if not asked for
  std::vector<LoadRow> load;               // ordered by system, then calculator
  std::vector<RankTimes> ranks;            // what each rank spent its time on
  std::size_t systems = 0;                 // number of systems in `load`
  std::vector<WallRow> walls;
  bool has_tail = false;                   // the ranks' tails have been added
};

/// The tables of a run, written frame by frame. run.json and the spans are elsewhere.
class Log {
 public:
  /// Creates the directory and empty tables; with `first_frame` above 0, continues an earlier run's tables and keeps
  /// their rows of earlier frames. Throws LogError, naming the path, on failure.
  Log(const std::string& directory, std::vector<std::string> hosts, std::uint64_t first_frame = 0);

  void add(const FrameRow& row);
  void add(const std::vector<Link>& links);  // in the first frame that this run or continuation logs
  void add(const BalanceRow& row);  // buffered until write_balance()
  void write_balance();
  /// kind: "start", "continued", "end", "crowded", ...
  void event(const std::string& kind, std::uint64_t frame, const std::string& text);
  /// Waits until all rows so far are on disk. Throws LogError if they cannot be written.
  void sync();

 private:
  std::string directory_;
  std::vector<std::string> hosts_;
  std::uint64_t first_frame_;
  jsonl::JsonlTable frames_, load_, density_, walls_, times_, waits_, links_, balance_, events_;
};

}  // namespace motes::engine
