// Neighbours that decide by themselves what goes over the cut between them.
#pragma once

#include <vector>

#include "frame/population.h"
#include "frame/rank.h"
#include "frame/script.h"

namespace motes::frame {

/// Calculators: tells each partner the loads of these systems, hears theirs, and decides what to give. What neighbours
/// tell each other is all that either needs; both come to the same order, and the donor acts on it.
std::vector<Request> decide_with_neighbours(Rank& rank, const Script& script, const Calculator& calculator,
                                            const Round& round, const std::vector<std::size_t>& systems,
                                            const std::vector<std::int32_t>& partners);

}  // namespace motes::frame
