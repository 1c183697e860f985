// A round: systems that share their messages (paper 3.3), and the state of that conversation.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "comm/message.h"
#include "engine/session/report.h"

namespace motes::engine {

/// How several systems share a frame (API: World.combine). one_by_one: each finishes its conversations before the next
/// one computes. together: all share their messages. overlapped: one system's messages travel while the next computes.
enum class Combine : std::uint8_t { one_by_one, together, overlapped };

struct Round {
  std::size_t first = 0;  // systems first .. last - 1
  std::size_t last = 0;
  std::uint32_t turn = 0;
  std::map<int, comm::Message> leaving;  // migrants by destination
  Verdict verdict;
  Orders orders;
  double reported_s = 0;  // when this rank's report was sent

  // This rank's report, kept until the ranks below have reported.
  Report own{};
  std::vector<CalculatorLoad> own_loads{};  // on calculators, one per system
  std::vector<CalculatorTail> own_tails{};  // on calculators, one per system of the last frame
  comm::Spent own_spent{};  // what this rank spent the last frame's time on
  bool tells_tails = false;               // tails are sent in this round; the same on all ranks
};

}  // namespace motes::engine
