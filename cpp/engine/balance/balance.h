// balance (paper 3.2.5): the manager plans from the frame's loads while calculators exchange particles and send what is
// to be drawn (paper 3.2.4), and tells them its plan; they hear it at the end of the frame. Or neighbours that it
// brings together decide by themselves; or all neighbours, without it (neighbours.h). Donors find the new cuts; the
// manager sends all of them with the next frame's births, and waits for donors no sooner than it needs to. What is then
// outside its domain goes to its owner in that frame's exchange: donation needs no messages of its own.
#pragma once

#include "engine/parts/manager.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Tells whether cuts may move at all.
bool balances(const Rank& rank, const Script& script);

/// The systems whose cuts a round decides on; where the sum over systems counts, or the manager does not, all of them
/// in the last round.
std::vector<std::size_t> systems_to_balance(const Rank& rank, const Script& script, const Round& round);

/// Tells whether a round has a plan.
bool plans(const Rank& rank, const Script& script, const Round& round);

/// Manager: what the reports of a round say about loads.
void note_loads(const Rank& rank, const Script& script, Manager& manager, const Round& round, const Loads& loads);

/// Manager, for the log: what neighbours decided without it.
void note_decisions(const Rank& rank, const Script& script, Manager& manager, const std::vector<Decision>& decisions);

/// Manager: plans from the loads of each round, and tells all ranks. Where the policy fails it tells them that.
void plan(Rank& rank, const Script& script, Manager& manager);

/// Receives the plan of each round at the end of the frame. Donors find their cuts and tell the manager; nobody waits
/// for answers. Throws on all ranks if the policy failed. Collective.
void balance(Rank& rank, const Script& script, Calculator& calculator, Manager& manager);

/// Manager: before it deals births, the cuts that follow from the last frame's proposals.
void take_all_proposals(Rank& rank, const Script& script, Manager& manager);

}  // namespace motes::engine
