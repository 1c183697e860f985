// All-reduce among calculators: each has some numbers, and all hear the largest, or the sum, of each.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/session/rank.h"
#include "engine/session/round.h"

namespace motes::engine {

/// The first number says whether a calculator has failed; what has failed may say no more than that.
using Maxima = std::vector<float>;

/// Calculators, collective: the maxima over all of them. log2(n) messages each: in step s a calculator tells the one
/// 2^s places ahead what it has heard so far (dissemination; Hensgen, Finkel, Manber 1988).
Maxima all_reduce_max(Rank& rank, const Round& round, Maxima numbers);

/// Calculators, collective: adds up the numbers of all, as many everywhere. Each sums its part of them and tells it to
/// the others (reduce-scatter, then all-gather): 2 (n - 1) messages, which together carry the numbers twice. Returns
/// the bytes that were sent.
std::uint64_t all_reduce_sum(Rank& rank, const Round& round, comm::Phase phase, std::vector<std::int64_t>& numbers);

}  // namespace motes::engine
