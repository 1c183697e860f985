// spawn: particles create children at events such as birth, death or collision. Children are born at the end of the
// frame, at their parents' positions. Calculators report the events; the manager numbers the children in the order of
// systems, rules and parents' ids, and sends each calculator, with the verdict, the parents whose children it owns; the
// calculators create the children.
#pragma once

#include <functional>

#include "engine/parts/manager.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Calculator: notes the events that spawn rules apply to, before this frame's dead are removed. Each rule counts a
/// particle once.
void note_events(const Rank& rank, const System& system, Population& here);

/// Calculator, before an interaction: notes the events of the dead so far that spawn rules apply to, and removes them.
void clear_dead(const Rank& rank, const System& system, Population& here);

/// Manager: numbers the children of a round's events and finds their owners.
void collect_parents(const Rank& rank, const Script& script, Manager& manager, const Round& round,
                     const std::vector<SystemReport>& reports, Judgement& judgement);

/// Creates the children of this frame's events on calculators and counts them on all ranks. Collective.
void spawn(Rank& rank, Script& script, Calculator& calculator);

}  // namespace motes::engine
