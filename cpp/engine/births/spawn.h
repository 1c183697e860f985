// spawn: events in the lives of particles make others. Children are born at the end of the frame, where their parents
// are then. Calculators report the events; the manager numbers the children in the order of systems, rules and parents'
// ids, and tells each calculator, with the verdict, which parents' children belong to it; the calculators make them.
#pragma once

#include <functional>

#include "engine/parts/manager.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Calculator, before the dead of this frame are removed: the events that the spawn rules ask for. Each rule counts a
/// particle once.
void note_events(const Rank& rank, const System& system, Population& here);

/// Calculator, before an interaction: the dead so far are removed, with the events that the spawn rules ask of them
/// noted.
void clear_dead(const Rank& rank, const System& system, Population& here);

/// Manager: numbers the children of a round's events, and says to whom they belong.
void collect_parents(const Rank& rank, const Script& script, Manager& manager, const Round& round,
                     const std::vector<SystemReport>& reports, Judgement& judgement);

/// Creates the children of this frame's events on calculators and counts them on all ranks. Collective.
void spawn(Rank& rank, Script& script, Calculator& calculator);

}  // namespace motes::engine
