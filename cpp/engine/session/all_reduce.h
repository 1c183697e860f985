// All-reduce (max) among calculators: each contributes some numbers and gets the maximum of each.
#pragma once

#include <vector>

#include "engine/session/rank.h"
#include "engine/session/round.h"

namespace motes::engine {

/// The first number says whether a calculator has failed; what has failed may say no more than that.
using Maxima = std::vector<float>;

/// Calculators, collective: the maxima over all of them. log2(n) messages each: in step s a calculator tells the one
/// 2^s places ahead what it has heard so far (dissemination; Hensgen, Finkel, Manber 1988).
Maxima all_reduce_max(Rank& rank, const Round& round, Maxima word);

}  // namespace motes::engine
