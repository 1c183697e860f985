// How long a rank waits for another: when it looks around, when it warns, and when it gives up.
#pragma once

#include <functional>
#include <string>

#include "comm/errors.h"

namespace motes::comm {

/// What a communicator asks of its owner. Every function may be empty.
struct Watch {
  /// Called about every 50 ms while waiting, with the rank waited for (-1: several): may throw to end the wait.
  std::function<void(int waited_for)> while_waiting;
  /// "rank 3 (calculator 1)".
  std::function<std::string(int rank)> describe;
  /// Whether the process of a rank is known to live. False where it is gone and where nobody can tell (another host).
  std::function<bool(int rank)> alive;
  /// Called once per wait, with a sentence for the user, when the stall limit has passed and the process lives.
  std::function<void(const std::string& text)> warn;
  /// Seconds without an answer after which a wait throws Stalled; ten times as long while the process lives.
  double stall_s = 60;

  std::string name(int rank) const { return describe ? describe(rank) : "rank " + std::to_string(rank); }
};

/// One wait. Time during which this process was suspended (Ctrl-Z, a laptop's lid) does not count: the other rank may
/// have been suspended just as long.
class Wait {
 public:
  static constexpr double kLookEvery = 0.05;  // seconds
  static constexpr double kWhileAlive = 10;   // stall limits, if the process waited for is known to live

  /// `limits`: the stall limit of this wait, in units of Watch::stall_s.
  Wait(const Watch& watch, int self, std::string purpose, double limits, double now_s);

  /// To be called over and over with the time and the rank waited for (-1: several). When a look is due it calls
  /// Watch::while_waiting, and warns or throws Stalled where the limit has passed.
  void look(double now_s, int for_rank);

  /// When look() next does more than to note the time.
  double next_look_s() const { return next_look_s_; }

 private:
  std::string told(int for_rank, const std::string& life) const;

  const Watch& watch_;
  int self_;
  std::string purpose_;
  double limit_s_;
  double last_s_;
  double next_look_s_;
  double waited_s_ = 0;  // without suspension
  bool warned_ = false;
};

}  // namespace motes::comm
