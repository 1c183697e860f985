// donate (paper 3.2.5): finds where a calculator's particles are, and the cut beyond which it gives particles away.
// These migrate in the next frame's exchange.
#pragma once

#include <vector>

#include "engine/session/rank.h"
#include "engine/session/report.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Calculator: answers a request.
Proposal propose(const Rank& rank, const Script& script, const Calculator& calculator, const Request& request);

/// Calculator, for the log: returns where each system's particles are at the frame's end.
std::vector<Density> densities(const Script& script, const Calculator& calculator);

}  // namespace motes::engine
