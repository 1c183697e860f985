// A round: systems whose conversations are held together (paper 3.3), and their state on the way.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "comm/message.h"
#include "engine/session/report.h"

namespace motes::engine {

/// How several systems share a frame (API: World.combine): each has all of its conversations before the next one
/// computes; all share their messages; or the messages of one travel while the next one computes.
enum class Combine : std::uint8_t { one_by_one, together, overlapped };

struct Round {
  std::size_t first = 0;  // systems first .. last - 1
  std::size_t last = 0;
  std::uint32_t turn = 0;
  std::map<int, comm::Message> leaving;  // migrants by destination
  Verdict verdict;
  Orders orders;
  double reported_s = 0;  // when this rank's report was sent

  // This rank's report, until those below it have reported.
  Report own{};
  std::vector<CalculatorLoad> own_loads{};  // on calculators, one per system
  std::vector<CalculatorTail> own_tails{};  // on calculators, one per system of the last frame
  comm::Spent own_spent{};  // where this rank's time of the last frame went
  bool tells_tails = false;               // the log needs them in this round: the same on all ranks
};

}  // namespace motes::engine
