// Where a rank's time goes: each second belongs to one activity or to a wait for another rank, without gaps.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "comm/message.h"

namespace motes::comm {

/// What a rank does when it does not wait. other: between phases, and what the system took from births, act and picture
/// (other processes on this core, sleep, the disk).
enum class Activity : std::uint8_t { script, births, act, talk, picture, log, other };
inline constexpr int kActivities = 7;

/// Seconds that a rank waited for messages of one phase from another rank. rank -1: from several; phase kPhases: for
/// its own messages to leave.
struct Waited {
  std::int32_t rank = -1;
  std::int32_t phase = kPhases;
  double seconds = 0;
};

/// A rank's seconds from one border between frames to the next. wall_s is the sum of `activities` and of `waits`.
struct Spent {
  std::array<double, kActivities> activities{};
  double wall_s = 0;
  double messages_s = 0;  // inside calls that send and receive; a part of the activities
  double chain_s = 0;     // since the start: the longest chain of work that leads here (Ledger::chain_s)
  std::vector<Waited> waits;
};

class Ledger {
 public:
  /// Counts time as `next` from now on. Returns the activity before.
  Activity turn_to(Activity next);
  /// Where one thread does all of a rank's work, time that it did not get from the system is told from work.
  void one_thread(bool one) { one_thread_ = one; }

  /// A wait from `start_s` to now is over, in which this thread used `cpu_s` of processor time.
  void note_wait(std::int32_t rank, std::int32_t phase, double start_s, double cpu_s);
  /// Calls `told` with each wait, when it began and when it ended.
  void on_wait(std::function<void(const Waited& wait, double start_s, double end_s)> told) { told_ = std::move(told); }
  void note_messages(double seconds) { messages_s_ += seconds; }
  double waited_s() const { return waited_s_; }

  /// Length of the longest chain of work that leads to this moment, in seconds: this rank's own work, or that of a rank
  /// whose message it needed, and so on back to the start. The run would take so long if messages took no time.
  double chain_s() const;
  /// A message has arrived whose sender stood at `chain_s`.
  void follow(double chain_s);

  /// Returns the seconds since the last call, and starts anew.
  Spent take();
  /// Forgets the time since the last take(): the run has paused.
  void restart();

 private:
  void settle(Activity next);

  Activity now_ = Activity::script;
  bool one_thread_ = true;
  double since_s_ = 0, since_cpu_s_ = 0;  // when now_ began, or was settled last
  double waits_s_ = 0, waits_cpu_s_ = 0;  // waits since then
  double waited_s_ = 0;                   // all waits
  double messages_s_ = 0;                 // since the last take()
  double worked_s_ = 0;  // all activities before the last take(), calls that send and receive left out
  double slack_s_ = 0;  // by which others' chains are longer than this rank's work
  std::array<double, kActivities> activities_{};
  std::vector<Waited> waits_;
  std::function<void(const Waited&, double, double)> told_;
};

/// Counts time as an activity from its construction to its destruction.
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
