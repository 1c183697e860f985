// Bounds the size of birth histories: births of particles that are dead on all ranks are forgotten, and a system whose
// history exceeds its share of memory stores birth values from then on.
#pragma once

#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Marks the systems whose history has grown, so the next reports include their lowest live id. Call before the reports
/// of a frame. All ranks record the same births, so they mark the same systems.
void ask_for_oldest(const Script& script);

/// Stores birth values for systems whose history exceeds the limit. Call at the frame's end, after hear_verdict() has
/// pruned the histories.
void bound_histories(const Script& script, const Calculator& calculator);

}  // namespace motes::engine
