// act and move (paper 3.2.2, 3.2.3): calculators run the recorded list in one pass and set migrants aside.
#pragma once

#include "engine/births/create.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Runs a round's lists; what leaves this domain is packed for its owners.
void act(Rank& rank, Script& script, Calculator& calculator, Round& round, Newborn& newborn);

/// Sorts each calculator's particles into drawing order at the frame's end, where the list says `sort`.
void sort_all(Rank& rank, const Script& script, Calculator& calculator);

/// Calls the script's function of one system's particles, at a time of the animation (seconds).
void call_back(const Calculator& calculator, std::size_t system, const recording::Callback& callback, double time,
               std::size_t begin);

/// Calls the script's function, which meanwhile sees all that the list runs over.
void ask_script(const Calculator& calculator, Population& here, const Call& call);

}  // namespace motes::engine
