// The recorded list on one calculator's particles: actions in fused passes, births where they stand, callbacks between.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "engine/session/rank.h"
#include "engine/state/population.h"

namespace motes::engine {

/// Adds a group's particles to the population.
using Append = std::function<void(const BirthGroup&)>;
/// Calls a function of the script, of the particles from this one on.
using CallBack = std::function<void(const recording::Callback&, double time, std::size_t begin)>;

/// Runs the items that have not run yet. Old particles run all of them; newborn ones enter the list behind the call
/// that made them. What happened adds to `here.outcome`: the dead stay where they are, and keep moving, until the frame
/// ends, so a list that runs in parts comes to the same. `keep_hits`: all that bounced are noted, whatever the rules
/// say so far.
void run_list(const Rank& rank, const System& system, Population& here, const Append& append, const CallBack& call_back,
              bool keep_hits);

/// The part of space that belongs to this calculator; everything where ids or a curve decide.
program::Region region_of(const Rank& rank, const System& system);

/// Looks through all particles for those outside the domain.
void find_migrants(const Rank& rank, const System& system, Population& here);

/// Returns the particles of here.outcome.left by owner. A particle at infinity or NaN may belong to this calculator all
/// the same.
std::map<int, std::vector<std::uint32_t>> migrants_by_owner(const Rank& rank, const System& system,
                                                            const Population& here);

/// Obeys the sorts from item `first` of the list on: the particles stand in the order of drawing.
void sort(const Rank& rank, const System& system, particles::Store& store, std::size_t first);

}  // namespace motes::engine
