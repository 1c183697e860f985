// donate (paper 3.2.5): where a calculator's particles are, and the cut beyond which lie those that it gives away. They
// go to their owner with the next frame's exchange.
#pragma once

#include <vector>

#include "engine/session/rank.h"
#include "engine/session/report.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Calculator: answers a request.
Proposal propose(const Rank& rank, const Script& script, const Calculator& calculator, const Request& request);

/// Calculator, for the log: where particles are at the frame's end, per system.
std::vector<Density> densities(const Script& script, const Calculator& calculator);

}  // namespace motes::engine
