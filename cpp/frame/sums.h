// Sums over the particles of all ranks: each rank on the way up the tree adds what those below it have, and the result
// goes down again.
#pragma once

#include "frame/rank.h"
#include "recording/sums.h"

namespace motes::frame {

/// Collective, when all ranks have agreed that none of them failed: what all of them have, on every rank.
recording::Totals total_of_all(Rank& rank, recording::Summed own);

}  // namespace motes::frame
