// Sums over the particles of all ranks: each rank on the way up the tree adds what those below it have, and the result
// goes down again.
#pragma once

#include "engine/session/rank.h"
#include "program/sums.h"

namespace motes::engine {

/// Collective, when all ranks have agreed that none of them failed: what all of them have, on every rank.
program::Totals total_of_all(Rank& rank, program::Summed own);

}  // namespace motes::engine
