// All-reduce among calculators: every calculator gets the maximum, or the sum, of each number.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/session/rank.h"
#include "engine/session/round.h"

namespace motes::engine {

/// Element 0 is a failure flag; a calculator that has failed may send only that.
using Maxima = std::vector<float>;

/// Returns the elementwise maxima over all calculators. Collective over calculators. Each sends log2(n) messages: in
/// step s, its maxima so far, to the calculator 2^s places ahead (dissemination; Hensgen, Finkel, Manber 1988).
Maxima all_reduce_max(Rank& rank, const Round& round, Maxima numbers);

/// Replaces `numbers`, equally many on all calculators, with their elementwise sums over all of them. Returns the bytes
/// sent. Collective over calculators. Each sums one part and sends it to the others (reduce-scatter, then all-gather):
/// 2 (n - 1) messages per calculator, in which each number is sent twice.
std::uint64_t all_reduce_sum(Rank& rank, const Round& round, comm::Phase phase, std::vector<std::int64_t>& numbers);

}  // namespace motes::engine
