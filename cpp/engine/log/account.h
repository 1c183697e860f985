// The manager's account of a frame: turns reports into rows of the log. What a rank does after its report (exchange,
// render) is part of its next report, so a frame's row is complete one frame later.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/log/log.h"
#include "engine/session/links.h"
#include "engine/session/report.h"
#include "engine/session/reports.h"
#include "engine/session/settings.h"
#include "engine/state/script.h"
#include "roles/cast.h"

namespace motes::engine {

/// Returns how the run of this log began: as a new run, from a checkpoint, or after a loss of ranks.
Opening opening_of(const Logging& logging);

class Account {
 public:
  /// Creates the log's directory and tables, or continues those of an earlier run, and writes an event about it. Throws
  /// LogError, naming the path, on failure.
  void open_log(const Logging& logging);
  Log* log() { return log_.get(); }
  /// Logs how fast messages travel from now on; no effect without a log.
  void note_links(const std::vector<Link>& links);

  /// Notes a judged round; the first round begins a row.
  void note_round(const Script& script, const Round& round, const Judged& judged, const roles::Cast& cast,
                  const roles::Tree& tree);
  /// Notes who created the frame's births.
  void note_births(Births by);
  /// Notes the number of children that a calculator gets at the frame's end.
  void note_children(std::size_t system, int calculator, std::uint64_t count);
  /// Closes the row when all rounds are judged and children numbered; the ranks' tails are added later.
  void close_row(const Script& script, const roles::Cast& cast, bool digest);

  /// Adds the merged tail of all ranks to the last row. A frame lasts from the latest end of the frame before on any
  /// rank to its own latest end, so that all frames' seconds add up to the run's.
  void note_tail(const Tail& tail);
  /// Notes that all ranks have restarted their clocks (comm::Ledger::restart).
  void restart_clock() { ended_s_ = 0; }
  /// Adds each calculator's tails to the last row.
  void note_tails(const std::vector<CalculatorTail>& tails, const roles::Tree& tree);
  /// Adds what each rank spent its time on to the last row.
  void note_times(std::vector<RankTimes> times);
  /// Writes complete rows to the log. Call when no rank waits for the manager, so none waits for the disk.
  void write_rows();
  /// Writes complete rows and waits until they are on disk. After a conversation outside a frame, which brings the last
  /// frame's tails, these are the rows of all frames so far. Throws LogError if they cannot be written.
  void secure_rows();

  /// Returns the row of the last complete frame.
  const std::optional<FrameRow>& last_row() const { return last_row_; }

 private:
  void note_loads(const System& system, const Loads& loads, std::size_t number, const roles::Cast& cast,
                  const roles::Tree& tree);
  void note_imbalance(const roles::Cast& cast);

  std::unique_ptr<Log> log_;
  FrameRow row_;                      // row of the frame whose rounds are being judged
  std::optional<FrameRow> open_row_;  // a closed row without tails
  std::optional<FrameRow> last_row_;
  bool row_is_new_ = false;  // `last_row_` is not in the log yet
  double ended_s_ = 0;       // the latest end of the last frame that is in a row
};

}  // namespace motes::engine
