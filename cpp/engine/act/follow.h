// follow: each particle is attracted to the one with the next id, wherever that is. Each calculator is the keeper of a
// range of ids: calculators send their particles' positions to the keepers, which answer with the positions of the next
// particles.
#pragma once

#include "engine/act/interact.h"

namespace motes::engine {

/// Runs a `follow` action. Returns false if a calculator has failed. Collective over calculators.
bool follow(Rank& rank, const Script& script, Calculator& calculator, const Round& round,
            const Interaction& interaction);

}  // namespace motes::engine
