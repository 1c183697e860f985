// act and move (paper 3.2.2, 3.2.3): calculators run the recorded list and pack migrants.
#pragma once

#include "engine/births/create.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Runs a round's lists and packs migrants for their owners.
void act(Rank& rank, Script& script, Calculator& calculator, Round& round, Newborn& newborn);

/// Sorts this calculator's particles into drawing order at the frame's end, for lists that contain `sort`.
void sort_all(Rank& rank, const Script& script, Calculator& calculator);

/// Calls a callback of the script for one system's particles from `begin` on. `time`: seconds of the animation.
void call_back(const Calculator& calculator, std::size_t system, const recording::Callback& callback, double time,
               std::size_t begin);

/// Calls a function of the script, which can read all particles that the list runs over.
void ask_script(const Calculator& calculator, Population& here, const Call& call);

}  // namespace motes::engine
