// balance (paper 3.2.5): the manager plans from the frame's loads while calculators exchange particles and send records
// (paper 3.2.4); they receive its plan at the end of the frame. Alternatively, neighbours decide among themselves:
// those that the manager brings together, or all of them without it (neighbours.h). Donors find the new cuts; the
// manager waits for them only before the next frame's births, and sends all cuts with those. Particles that are then
// outside their domain migrate in that frame's exchange: donation needs no messages of its own.
#pragma once

#include "engine/parts/manager.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Returns whether cuts may move in this conversation.
bool balances(const Rank& rank, const Script& script);

/// Returns the systems whose cuts a round decides on. If the policy uses the sum over systems, or works without the
/// manager: all systems in the last round, none in others.
std::vector<std::size_t> systems_to_balance(const Rank& rank, const Script& script, const Round& round);

/// Returns whether the manager makes a plan for a round.
bool plans(const Rank& rank, const Script& script, const Round& round);

/// Manager: notes the loads in the reports of a round.
void note_loads(const Rank& rank, const Script& script, Manager& manager, const Round& round, const Loads& loads);

/// Manager: notes, for the log, the decisions of neighbours without it.
void note_decisions(const Rank& rank, const Script& script, Manager& manager, const std::vector<Decision>& decisions);

/// Manager: plans from the loads of each round and sends the plans to all ranks. If the policy fails, it sends the
/// failure.
void plan(Rank& rank, const Script& script, Manager& manager);

/// Receives the plan of each round at the end of the frame. Donors find their cuts and send them to the manager; no
/// rank waits for answers. Throws on all ranks if the policy failed. Collective.
void balance(Rank& rank, const Script& script, Calculator& calculator, Manager& manager);

/// Manager: computes the new cuts from the last frame's proposals, before it deals births.
void take_all_proposals(Rank& rank, const Script& script, Manager& manager);

}  // namespace motes::engine
