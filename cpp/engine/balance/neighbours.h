// Neighbours that decide by themselves what goes over the cut between them: those that the manager brings together at
// the frame's end, or all, without it. In the second case they compare their loads before they report. Reports take the
// new cuts up the tree, and the verdict takes them down again, so that all ranks know all cuts before the next frame.
#pragma once

#include <vector>

#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Calculators: tells each partner the loads of these systems, hears theirs, and decides what to give. What neighbours
/// tell each other is all that either needs; both come to the same order, and the donor acts on it.
std::vector<Request> decide_with_neighbours(Rank& rank, const Script& script, const Calculator& calculator,
                                            const Round& round, const std::vector<std::size_t>& systems,
                                            const std::vector<std::int32_t>& partners);

/// Tells whether neighbours compare their loads in this round without the manager: in a frame's last round, for all
/// systems.
bool compare_alone(const Rank& rank, const Script& script, const Round& round);

/// Returns how many particles of a system a calculator will have after the exchange, as far as neighbours know before
/// it: the live ones, corrected for what the frame's new cuts move. Otherwise the same difference would be evened out
/// twice. Particles that cross a cut by themselves count in the next frame.
std::uint64_t expected_of(const Script& script, std::size_t system, int calculator, std::uint64_t alive);

/// Calculators, where neighbours compare: tells both the loads of all systems, hears theirs, and finds the cuts of what
/// this one gives.
std::vector<Decision> decide_alone(Rank& rank, const Script& script, const Calculator& calculator, const Round& round);

/// Applies the cuts of the last verdict, at the beginning of a frame, on all ranks.
void take_new_cuts(Rank& rank, Script& script, const Calculator& calculator);

}  // namespace motes::engine
