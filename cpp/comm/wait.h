// How long a rank waits for another: when it looks around, when it warns, and when it gives up.
#pragma once

#include <functional>
#include <string>

#include "comm/errors.h"

namespace motes::comm {

/// What a rank knows of another rank's process.
struct Life {
  enum class State { unknown, gone, lives };  // unknown: on another host, say
  State state = State::unknown;
  std::string text;  // for messages: "its process 4711 is stopped"; empty: what the state says
};

/// What a communicator asks of its owner. Every function may be empty.
struct Watch {
  /// Called about every 50 ms while waiting, with the rank waited for (-1: several): may throw to end the wait.
  std::function<void(int waited_for)> while_waiting;
  /// "rank 3 (calculator 1)".
  std::function<std::string(int rank)> describe;
  /// Whether the process of a rank lives (-1: those of all ranks).
  std::function<Life(int rank)> life;
  /// Called with a sentence for the user each time that a wait has lasted `warn_s` longer.
  std::function<void(const std::string& text)> warn;
  double warn_s = 60;
  /// Seconds after which a wait throws Stalled, whatever lives. 0: none; then it throws only where the process waited
  /// for is gone, or where nobody could tell for kUnknown * warn_s.
  double limit_s = 0;

  std::string name(int rank) const { return describe ? describe(rank) : "rank " + std::to_string(rank); }
};

/// One wait. Time during which this process was suspended (Ctrl-Z, a laptop's lid) does not count: the other rank may
/// have been suspended just as long.
class Wait {
 public:
  static constexpr double kLookEvery = 0.05;  // seconds
  static constexpr double kUnknown = 10;      // Watch::warn_s, where nobody can tell whether a process lives

  /// `patience`: this wait's warnings and limits come so many times as late as Watch says.
  Wait(const Watch& watch, int self, std::string purpose, double patience, double now_s);

  /// To be called over and over with the time and the rank waited for (-1: several). When a look is due it calls
  /// Watch::while_waiting, and warns or throws Stalled where it is time.
  void look(double now_s, int for_rank);

  /// When look() next does more than to note the time.
  double next_look_s() const { return next_look_s_; }

 private:
  void warn(int for_rank, const Life& life) const;
  [[noreturn]] void give_up(int for_rank, const Life& life) const;
  std::string told(int for_rank) const;

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
