#include "comm/wait.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace motes::comm {
namespace {

// Formats a number: "60", "0.5".
std::string number(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.6g", value);
  return digits;
}

std::string whole(double seconds) { return std::to_string(static_cast<long long>(seconds)); }

std::string text_of(const Life& life) {
  if (!life.text.empty()) return life.text;
  switch (life.state) {
    case Life::State::gone: return "its process is gone";
    case Life::State::lives: return "its process is alive";
    default: return "it is unknown whether its process is alive";
  }
}

}  // namespace

Wait::Wait(const Watch& watch, int self, std::string purpose, double patience, double now_s)
    : watch_(watch), self_(self), purpose_(std::move(purpose)), warn_s_(patience * watch.warn_s),
      limit_s_(patience * watch.limit_s), last_s_(now_s), next_look_s_(now_s + kLookEvery), next_warning_s_(warn_s_) {}

void Wait::look(double now_s, int for_rank) {
  // Naps last 2 ms at most. A longer gap means that this process did not run, so the other rank may not have been
  // silent. Such gaps are common on an overloaded machine, so each counts, but only a little.
  const double shortest = watch_.limit_s > 0 ? std::min(watch_.limit_s, watch_.warn_s) : watch_.warn_s;
  waited_s_ += std::min({now_s - last_s_, 1.0, shortest / 4});
  last_s_ = now_s;
  if (now_s < next_look_s_) return;
  next_look_s_ = now_s + kLookEvery;
  if (watch_.while_waiting) watch_.while_waiting(for_rank);
  const bool over = limit_s_ > 0 && waited_s_ > limit_s_;
  if (!over && waited_s_ <= next_warning_s_) return;
  const Life life = watch_.life ? watch_.life(for_rank) : Life{};
  const bool unknown_for_long = life.state == Life::State::unknown && limit_s_ <= 0 && waited_s_ > kUnknown * warn_s_;
  if (over || life.state == Life::State::gone || unknown_for_long) give_up(for_rank, life);
  next_warning_s_ += warn_s_;
  if (watch_.warn) warn(for_rank, life);
}

// Warns with a sentence like "rank 1 (manager) waited 60 s for rank 3 (calculator 1): frame 7, phase report; its
// process is alive, so it keeps waiting (MOTES_STALL_S=seconds sets a limit)"
void Wait::warn(int for_rank, const Life& life) const {
  std::string rest = "it keeps waiting (MOTES_STALL_S=seconds sets a limit)";
  if (limit_s_ > 0) {
    rest = "it waits until the limit that was set by MOTES_STALL_S=" + number(watch_.limit_s);
  } else if (life.state == Life::State::unknown) {
    rest = "it waits for " + whole(kUnknown * warn_s_) + " s in total (MOTES_STALL_S=seconds changes the limit)";
  }
  watch_.warn(message(for_rank) + "; " + text_of(life) + ", so " + rest);
}

void Wait::give_up(int for_rank, const Life& life) const {
  std::string why = text_of(life);
  if (life.state != Life::State::gone && limit_s_ > 0) {
    why += "; the limit was set by MOTES_STALL_S=" + number(watch_.limit_s) +
           ": increase it, or unset it to wait as long as the process is alive";
  } else if (life.state == Life::State::unknown) {
    why += "; increase the limit, by default MOTES_STALL_S=" + whole(kUnknown * watch_.warn_s);
  }
  throw Stalled(for_rank, message(for_rank) + " (" + why + ")");
}

std::string Wait::message(int for_rank) const {
  const std::string whom = for_rank < 0 ? "other ranks" : watch_.name(for_rank);
  return watch_.name(self_) + " waited " + whole(waited_s_) + " s for " + whom + ": " + purpose_;
}

}  // namespace motes::comm
