// Neighbours that decide among themselves how many particles cross the cut between them: those that the manager brings
// together at the frame's end, or all of them without it. In the second case they compare their loads before they
// report. The new cuts travel up the tree with the reports and down with the verdict, so all ranks know them before the
// next frame.
#pragma once

#include <vector>

#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Calculator: exchanges the loads of these systems with each partner, and returns what this one gives. Both partners
/// decide from the same loads, so they agree on the order, and the donor carries it out.
std::vector<Request> decide_with_neighbours(Rank& rank, const Script& script, const Calculator& calculator,
                                            const Round& round, const std::vector<std::size_t>& systems,
                                            const std::vector<std::int32_t>& partners);

/// Returns whether neighbours compare their loads in this round without the manager: in a frame's last round, for all
/// systems.
bool compare_alone(const Rank& rank, const Script& script, const Round& round);

/// Returns how many particles of a system a calculator is expected to have after the exchange: `alive`, corrected for
/// those that the frame's new cuts move. Otherwise the same difference would be evened out twice. Particles that move
/// across a cut themselves count in the next frame.
std::uint64_t expected_of(const Script& script, std::size_t system, int calculator, std::uint64_t alive);

/// Calculator, if neighbours compare without the manager: exchanges the loads of all systems with both neighbours, and
/// returns the cuts of what this one gives.
std::vector<Decision> decide_alone(Rank& rank, const Script& script, const Calculator& calculator, const Round& round);

/// Applies the cuts of the last verdict, at the beginning of a frame, on all ranks.
void take_new_cuts(Rank& rank, Script& script, const Calculator& calculator);

}  // namespace motes::engine
