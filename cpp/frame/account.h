// The manager's account of a frame: reports become rows of the log. What a rank did after its report (exchange,
// render) comes with its next report, so a frame's row is complete one turn later.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frame/log.h"
#include "frame/report.h"
#include "frame/script.h"
#include "roles/cast.h"

namespace motes::frame {

class Account {
 public:
  /// Makes the log's directory and tables. Throws std::runtime_error, naming the path, where it cannot.
  void open_log(const std::string& directory, const std::vector<std::string>& hosts);
  Log* log() { return log_.get(); }

  /// A round has been judged; with the first one a row begins.
  void note_round(const Script& script, const Round& round, const std::vector<Report>& reports, const Verdict& verdict,
                  const roles::Cast& cast);
  /// Children that a calculator gets at the frame's end.
  void note_children(std::size_t system, int calculator, std::uint64_t count);
  /// All rounds are judged: the row is complete, but for what ranks tell later.
  void close_row(const roles::Cast& cast, bool digest);

  /// What ranks did after their last report.
  void note_tails(const std::vector<Report>& reports, const roles::Cast& cast);
  /// Complete rows go to the log. A row is written a turn after it is complete: nobody waits for the disk then.
  void write_rows();

  /// The row that is being made: one entry per system and calculator.
  const std::vector<LoadRow>& loads() const { return row_.load; }
  /// The last frame about which all is known.
  const std::optional<FrameRow>& last_row() const { return last_row_; }

 private:
  void note_loads(const Script& script, const std::vector<Report>& reports, std::size_t system, std::size_t first,
                  const roles::Cast& cast);
  void note_imbalance(const roles::Cast& cast);
  void note_tail(int calculator, const Tail& tail, FrameRow& row);

  std::unique_ptr<Log> log_;
  FrameRow row_;                      // of the frame whose rounds are being judged
  std::optional<FrameRow> open_row_;  // waits for the tails
  std::optional<FrameRow> last_row_;
  bool row_is_new_ = false;  // the log does not have it yet
};

}  // namespace motes::frame
