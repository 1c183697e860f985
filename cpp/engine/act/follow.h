// follow: each particle is drawn to the one with the next id, wherever that is. Calculators keep ranges of ids: each
// tells the keepers where its particles are, and they tell it where the next ones are.
#pragma once

#include "engine/act/interact.h"

namespace motes::engine {

/// Calculators, collective. Returns false where one of them has failed.
bool follow(Rank& rank, const Script& script, Calculator& calculator, const Round& round,
            const Interaction& interaction);

}  // namespace motes::engine
