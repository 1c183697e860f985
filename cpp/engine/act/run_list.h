// Runs the recorded list on one calculator's particles: actions in fused passes, births at their places, and callbacks.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "engine/session/rank.h"
#include "engine/state/population.h"

namespace motes::engine {

/// Adds a birth group's particles to the population.
using Append = std::function<void(const BirthGroup&)>;
/// Calls a callback of the script for the particles from `begin` on.
using CallBack = std::function<void(const recording::Callback&, double time, std::size_t begin)>;

/// Runs the pending items: existing particles run all of them, newborn ones those after their birth. Adds the outcome
/// to `here.outcome`. The dead stay in place and keep moving until the frame ends, so a list that runs in parts gives
/// the same result. `keep_hits`: note all particles that bounced, even if no spawn rule needs them yet.
void run_list(const Rank& rank, const System& system, Population& here, const Append& append, const CallBack& call_back,
              bool keep_hits);

/// Returns this calculator's part of space; all of space if domains are cut by id or along a curve.
program::Region region_of(const Rank& rank, const System& system);

/// Finds the particles outside the domain, into here.outcome.left.
void find_migrants(const Rank& rank, const System& system, Population& here);

/// Returns the particles of here.outcome.left by owner, except those that this calculator owns, as it may for infinite
/// and NaN positions.
std::map<int, std::vector<std::uint32_t>> migrants_by_owner(const Rank& rank, const System& system,
                                                            const Population& here);

/// Sorts the particles into drawing order, by the `sort` actions from item `first` of the list on.
void sort(const Rank& rank, const System& system, particles::Store& store, std::size_t first);

}  // namespace motes::engine
