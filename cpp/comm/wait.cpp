#include "comm/wait.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace motes::comm {
namespace {

// "60", "0.5"
std::string number(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.6g", value);
  return digits;
}

std::string whole(double seconds) { return std::to_string(static_cast<long long>(seconds)); }

}  // namespace

Wait::Wait(const Watch& watch, int self, std::string purpose, double limits, double now_s)
    : watch_(watch), self_(self), purpose_(std::move(purpose)), limit_s_(limits * watch.stall_s), last_s_(now_s),
      next_look_s_(now_s + kLookEvery) {}

void Wait::look(double now_s, int for_rank) {
  // Waiting naps are below a millisecond. A longer gap means that this process did not run: then nobody can say that
  // the other rank was silent. On an overloaded machine such gaps are the rule, so each counts for a little.
  waited_s_ += std::min({now_s - last_s_, 1.0, watch_.stall_s / 4});
  last_s_ = now_s;
  if (now_s < next_look_s_) return;
  next_look_s_ = now_s + kLookEvery;
  if (watch_.while_waiting) watch_.while_waiting(for_rank);
  if (waited_s_ <= limit_s_) return;
  const bool alive = for_rank >= 0 && watch_.alive && watch_.alive(for_rank);
  if (!alive) {
    throw Stalled(for_rank,
                  told(for_rank, watch_.alive && for_rank >= 0 ? "its process is gone, or on another host" : ""));
  }
  if (waited_s_ > kWhileAlive * limit_s_) throw Stalled(for_rank, told(for_rank, "its process lives"));
  if (warned_) return;
  warned_ = true;
  if (watch_.warn) {
    watch_.warn(
        told(for_rank, "its process lives, so it goes on waiting, for " + whole(kWhileAlive * limit_s_) + " s in all"));
  }
}

// "rank 1 (manager) waited 60 s for rank 3 (calculator 1): frame 7, phase report (its process lives; ...)"
std::string Wait::told(int for_rank, const std::string& life) const {
  const std::string whom = for_rank < 0 ? "other ranks" : watch_.name(for_rank);
  return watch_.name(self_) + " waited " + whole(waited_s_) + " s for " + whom + ": " + purpose_ + " (" + life +
         (life.empty() ? "" : "; ") + "MOTES_STALL_S, now " + number(watch_.stall_s) + " s, sets the limit)";
}

}  // namespace motes::comm
