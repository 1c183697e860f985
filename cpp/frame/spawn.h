// spawn: events in the lives of particles make others. Children are born at the end of the frame, where their parents
// are then. Calculators report the events; the manager numbers the children in the order of systems, rules and parents'
// ids, and tells each calculator, with the verdict, which parents' children belong to it; the calculators make them.
#pragma once

#include "frame/manager.h"
#include "frame/population.h"
#include "frame/rank.h"
#include "frame/script.h"

namespace motes::frame {

/// Calculator, before the dead of this frame are removed: the events that the spawn rules ask for. Each rule counts a
/// particle once.
void note_events(const System& system, Population& here);

/// Manager: numbers the children of a round's events, and says to whom they belong.
void collect_parents(const Rank& rank, const Script& script, Manager& manager, const Round& round,
                     const std::vector<Report>& reports, Verdict& verdict, std::vector<Orders>& orders);

/// Manager: the children in the account of the frame, once all rounds are judged.
void note_children(const Script& script, Manager& manager, const std::vector<std::uint64_t>& alive);

/// All ranks, at the frame's end: counts, and on calculators the particles.
void spawn(Rank& rank, Script& script, Calculator& calculator);

}  // namespace motes::frame
