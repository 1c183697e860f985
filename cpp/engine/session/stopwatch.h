// Measures the phases of a frame on this rank: seconds for its report, and a timeline if the run keeps one.
#pragma once

#include <memory>
#include <string>

#include "comm/ledger.h"
#include "engine/session/report.h"
#include "engine/session/spans.h"

namespace motes::engine {

class Stopwatch {
 public:
  /// The ledger must outlive it.
  explicit Stopwatch(comm::Ledger& ledger) : ledger_(ledger) {}

  /// Counts the time from its construction to its destruction as `phase`.
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

  /// The run begins: `waited_s` seconds were spent waiting for messages before.
  void start();
  /// Starts counting anew. `in_frame`: phases go into the timeline as parts of `frame`.
  void begin(std::uint64_t frame, bool in_frame, double waited_s);
  /// The frame is over; its times are last().
  void end(double waited_s);

  const PhaseTimes& last() const { return last_; }
  /// Returns where this rank's time of the last frame went.
  const comm::Spent& spent() const { return spent_; }
  comm::Ledger& ledger() { return ledger_; }

  /// Writes each phase as a row of this rank's own file from now on. Throws std::runtime_error if the file cannot be
  /// made.
  void keep_spans(const std::string& directory, int rank, double zero, std::uint64_t first_frame = 0);
  /// Notes the time of a round's messages, from `start` to now.
  void note_messages(const std::string& system, double start);
  void write_spans();

 private:
  comm::Ledger& ledger_;
  PhaseTimes now_, last_;
  comm::Spent spent_;
  std::unique_ptr<Spans> spans_;
  std::uint64_t frame_ = 0;
  bool in_frame_ = false;
  double frame_start_s_ = 0;
  double waited_before_s_ = 0;
};

}  // namespace motes::engine
