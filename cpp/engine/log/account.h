// The manager's account of a frame: reports become rows of the log. What a rank did after its report (exchange,
// render) comes with its next report, so a frame's row is complete one turn later.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/log/log.h"
#include "engine/session/report.h"
#include "engine/session/reports.h"
#include "engine/session/settings.h"
#include "engine/state/script.h"
#include "roles/cast.h"

namespace motes::engine {

/// Returns how the run of this log began: anew, from a checkpoint, or after a loss of ranks.
Opening opening_of(const Logging& logging);

class Account {
 public:
  /// Makes the log's directory and tables, or goes on with those of an earlier run, and says so in an event. Throws
  /// LogError, naming the path, where it cannot.
  void open_log(const Logging& logging);
  Log* log() { return log_.get(); }

  /// Notes a judged round; the first one begins a row.
  void note_round(const Script& script, const Round& round, const Judged& judged, const roles::Cast& cast,
                  const roles::Tree& tree);
  /// Who created the frame's births.
  void note_births(Births by);
  /// Children that a calculator gets at the frame's end.
  void note_children(std::size_t system, int calculator, std::uint64_t count);
  /// Closes the row when all rounds are judged and children numbered; tails of the ranks are still to come.
  void close_row(const Script& script, const roles::Cast& cast, bool digest);

  /// Adds what ranks did after their last report to the last row.
  void note_tail(const Tail& tail);
  /// Adds what each calculator did to the last row, which is then complete.
  void note_tails(const std::vector<CalculatorTail>& tails, const roles::Tree& tree);
  /// Adds where each rank's time went to the last row.
  void note_times(std::vector<RankTimes> times);
  /// Complete rows go to the log. A row is written a turn after it is complete: nobody waits for the disk then.
  void write_rows();
  /// Writes them now, and waits until the disk has them. After a conversation outside the frame, which brings the last
  /// frame's tails, these are the rows of all frames so far. Throws LogError where the disk does not accept them.
  void secure_rows();

  /// The last frame about which all is known.
  const std::optional<FrameRow>& last_row() const { return last_row_; }

 private:
  void note_loads(const System& system, const Loads& loads, std::size_t number, const roles::Cast& cast,
                  const roles::Tree& tree);
  void note_imbalance(const roles::Cast& cast);

  std::unique_ptr<Log> log_;
  FrameRow row_;                      // row of the frame whose rounds are being judged
  std::optional<FrameRow> open_row_;  // waits for the tails
  std::optional<FrameRow> last_row_;
  bool row_is_new_ = false;  // the log does not have it yet
};

}  // namespace motes::engine
