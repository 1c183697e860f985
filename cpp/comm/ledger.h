// Where a rank's time goes: each second belongs to one activity or to a wait for another rank, without gaps.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "comm/message.h"

namespace motes::comm {

/// What a rank does when it does not wait. recovery: restoring the world after a loss of ranks, and the frames before
/// that whose results the loss destroyed. other: time between phases, and time during births, act and picture in which
/// this thread did not run (other processes on this core, sleep, the disk).
enum class Activity : std::uint8_t { script, births, act, talk, picture, log, checkpoint, recovery, other };
inline constexpr int kActivities = 9;

/// Seconds that a rank waited for messages of one phase from one rank. Rank -1: from several; phase kPhases: for its
/// own messages to leave. `late` is the rank that caused the wait: `sender`, or the rank for which the sender itself
/// had waited before it could send, and so on.
struct Waited {
  std::int32_t late = -1;
  std::int32_t sender = -1;
  std::int32_t phase = kPhases;
  double seconds = 0;
};

/// A rank's seconds from one border between frames to the next. wall_s is the sum of `activities` and of `waits`.
struct Spent {
  std::array<double, kActivities> activities{};
  double wall_s = 0;
  double messages_s = 0;  // inside calls that send and receive; a part of the activities
  double chain_s = 0;     // the longest chain of work since the start (Ledger::chain_s)
  double script_idle_s = 0;  // the part of the script's time in which this thread did not run
  double ended_s = 0;        // from the last start of all ranks (Ledger::restart) to the end of these seconds
  std::vector<Waited> waits;
};

/// The end of a frame on this rank's clock, from which pauses are taken away, and its chain of work then.
struct Border {
  double at_s = 0;
  double chain_s = 0;
};

class Ledger {
 public:
  /// Starts to count time as `next`. Returns the previous activity.
  Activity turn_to(Activity next);
  Activity now() const { return now_; }
  /// Sets whether one thread does all of this rank's work. If so, time in which it did not run does not count as work.
  void one_thread(bool one) { one_thread_ = one; }

  /// Records a wait of rank `self` from `start_s` to now, in which this thread used `cpu_s` of CPU time. `whom`: the
  /// sender and phase of the message. `delay`: what had kept the sender from sending it earlier.
  void note_wait(int self, const Waited& whom, double start_s, double cpu_s, const Delay& delay = {});
  /// Sets a function that is called with each wait, its start and its end.
  void on_wait(std::function<void(const Waited& wait, double start_s, double end_s)> told) { told_ = std::move(told); }
  void note_messages(double seconds) {
    if (now_ != Activity::recovery) messages_s_ += seconds;
  }
  double waited_s() const { return waited_s_; }
  /// Returns what to tell the receiver of a message that is sent now.
  Delay delay() const;

  /// Returns the length, s, of the longest chain of work that leads to this moment: this rank's own work, or that of a
  /// rank whose message it needed, and so on back to the start. The run would take this long if messages took no time.
  double chain_s() const;
  /// Records the arrival of a message whose sender's chain had this length.
  void follow(double chain_s);

  /// Returns the seconds since the last call and resets them.
  Spent take();
  /// Discards the time since the last take(), because the run begins or was paused. All ranks call it at the same time.
  void restart();

  /// Returns the end of the last seconds that take() returned.
  const Border& border() const { return border_; }
  /// Counts all time since an earlier border as recovery: the frames since then will run again. All ranks call it at
  /// the same time.
  void go_back(const Border& border);

 private:
  void settle(Activity next);
  void forget();
  double worked_s() const;  // since the last take()
  void add_wait(Waited wait);
  void remember(std::int32_t late, double seconds, double until_s);

  Activity now_ = Activity::script;
  bool one_thread_ = true;
  double since_s_ = 0, since_cpu_s_ = 0;  // when now_ began or was last settled
  double waits_s_ = 0, waits_cpu_s_ = 0;  // waits since then
  double waited_s_ = 0;                   // all waits
  double messages_s_ = 0;                 // since the last take()
  double worked_s_ = 0;  // all activities before the last take(), without calls that send and receive
  double slack_s_ = 0;  // by how much others' chains are longer than this rank's work
  double script_idle_s_ = 0;  // since the last take()
  double paused_s_ = 0;       // this rank's clock without pauses is wall_seconds() - paused_s_
  double started_s_ = 0;      // the last restart on that clock
  Border border_;
  Delay last_long_;            // the last long wait; its busy_s is not used
  double waited_until_s_ = 0;  // when it ended
  std::array<double, kActivities> activities_{};
  std::vector<Waited> waits_;
  std::function<void(const Waited&, double, double)> told_;
};

/// Counts time as an activity while it exists.
class ActivityScope {
 public:
  ActivityScope(Ledger& ledger, Activity activity) : ledger_(ledger), before_(ledger.turn_to(activity)) {}
  ~ActivityScope() { ledger_.turn_to(before_); }
  ActivityScope(const ActivityScope&) = delete;
  ActivityScope& operator=(const ActivityScope&) = delete;

 private:
  Ledger& ledger_;
  Activity before_;
};

}  // namespace motes::comm
