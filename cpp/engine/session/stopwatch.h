// Measures the phases of a frame on this rank, for its report and for the timeline if the run logs one.
#pragma once

#include <memory>
#include <string>

#include "comm/ledger.h"
#include "engine/session/report.h"
#include "engine/session/spans.h"

namespace motes::engine {

class Stopwatch {
 public:
  /// The ledger must outlive the stopwatch.
  explicit Stopwatch(comm::Ledger& ledger) : ledger_(ledger) {}

  /// Counts the time from its construction to its destruction: adds it to `seconds`, and to the timeline as `phase`.
  class Phase {
   public:
    Phase(Stopwatch& watch, double PhaseTimes::* seconds, const char* phase, std::string system = "");
    ~Phase();
    Phase(const Phase&) = delete;
    Phase& operator=(const Phase&) = delete;

   private:
    Stopwatch& watch_;
    double PhaseTimes::* seconds_;
    const char* phase_;
    std::string system_;
    comm::ActivityScope turn_;
    double start_, cpu_start_;
  };

  /// Resets the times. `in_frame`: phases enter the timeline as parts of `frame`. `waited_s`: seconds that this rank
  /// has spent waiting for messages so far.
  void begin(std::uint64_t frame, bool in_frame, double waited_s);
  /// Ends the frame; its times are then last(). `waited_s` as in begin().
  void end(double waited_s);

  const PhaseTimes& last() const { return last_; }
  /// Returns what this rank spent the last frame's time on.
  const comm::Spent& spent() const { return spent_; }
  comm::Ledger& ledger() { return ledger_; }

  /// Records a timeline in this rank's file from now on. Throws std::runtime_error if the file cannot be created.
  void keep_spans(const std::string& directory, int rank, double zero, std::uint64_t first_frame = 0);
  /// Adds the messages of a round, from `start` to now, to the timeline.
  void note_messages(const std::string& system, double start);
  void write_spans();

 private:
  comm::Ledger& ledger_;
  PhaseTimes now_, last_;
  comm::Spent spent_;
  std::unique_ptr<Spans> spans_;
  std::uint64_t frame_ = 0;
  bool in_frame_ = false;
  double waited_before_s_ = 0;
};

}  // namespace motes::engine
