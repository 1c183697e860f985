// How long a rank waits for another: when it checks, when it warns, and when it gives up.
#pragma once

#include <functional>
#include <string>

#include "comm/errors.h"

namespace motes::comm {

/// What a rank knows of another rank's process.
struct Life {
  enum class State { unknown, gone, lives };  // unknown: for example, on another host
  State state = State::unknown;
  std::string text;  // for messages, such as "its process 4711 is stopped"; empty: derived from the state
};

/// What a communicator does during waits, set by its owner. Every function may be empty.
struct Watch {
  /// Called about every 50 ms while waiting, with the awaited rank (-1: several). May throw to end the wait.
  std::function<void(int waited_for)> while_waiting;
  /// Returns the name of a rank for messages, such as "rank 3 (calculator 1)".
  std::function<std::string(int rank)> describe;
  /// Returns whether the process of a rank is alive (-1: those of all ranks).
  std::function<Life(int rank)> life;
  /// Called with a sentence for the user each time a wait has lasted another `warn_s`.
  std::function<void(const std::string& text)> warn;
  double warn_s = 60;
  /// Seconds after which a wait throws Stalled in any case. 0: no limit; it then throws only if the awaited process is
  /// gone, or if that was unknown for kUnknown * warn_s.
  double limit_s = 0;

  std::string name(int rank) const { return describe ? describe(rank) : "rank " + std::to_string(rank); }
};

/// One wait. Time during which this process was suspended (Ctrl-Z, a laptop's lid) does not count: the other rank may
/// have been suspended just as long.
class Wait {
 public:
  static constexpr double kLookEvery = 0.05;  // seconds
  static constexpr double kUnknown = 10;      // limit, in Watch::warn_s, if it is unknown whether a process is alive

  /// `patience`: factor on Watch's times for warnings and limits.
  Wait(const Watch& watch, int self, std::string purpose, double patience, double now_s);

  /// Must be called repeatedly, with the time and the awaited rank (-1: several). When a check is due, it calls
  /// Watch::while_waiting, and warns or throws Stalled if it is time.
  void look(double now_s, int for_rank);

  /// Returns when look() next does more than count the time.
  double next_look_s() const { return next_look_s_; }

 private:
  void warn(int for_rank, const Life& life) const;
  [[noreturn]] void give_up(int for_rank, const Life& life) const;
  std::string message(int for_rank) const;

  const Watch& watch_;
  int self_;
  std::string purpose_;
  double warn_s_;
  double limit_s_;  // 0: none
  double last_s_;
  double next_look_s_;
  double next_warning_s_;
  double waited_s_ = 0;  // without suspension
};

}  // namespace motes::comm
