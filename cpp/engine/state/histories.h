// Birth histories stay within bounds: what is dead on all ranks is forgotten, and a system whose history would take
// more than its share of memory keeps its birth values from then on.
#pragma once

#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Before the reports of a frame: the systems whose history has grown ask for the oldest particle. All ranks note the
/// same births, so they agree on which.
void ask_for_oldest(const Script& script);

/// At the frame's end, after the verdict has told which particles are dead.
void bound_histories(const Script& script, const Calculator& calculator);

}  // namespace motes::engine
