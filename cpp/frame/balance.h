// balance (paper 3.2.5): the manager plans from the frame's loads, or neighbours decide by themselves; donors find the
// new cuts; the manager sends all of them with the next frame's births, and waits for donors no sooner than it needs
// to. What is then outside its domain goes to its owner in that frame's exchange: donation needs no messages of its
// own. Where nothing is to be decided nobody says so: the verdict tells who has something to talk about.
#pragma once

#include "frame/manager.h"
#include "frame/population.h"
#include "frame/rank.h"
#include "frame/script.h"

namespace motes::frame {

/// Whether cuts may move at all.
bool balances(const Rank& rank, const Script& script);

/// The systems whose cuts a round decides on; where the sum over systems counts, all of them in the last round.
std::vector<std::size_t> systems_to_balance(const Rank& rank, const Script& script, const Round& round);

/// Manager: what the reports of a round say about loads.
void note_loads(const Rank& rank, const Script& script, Manager& manager, const Round& round);

/// Manager: what each calculator is asked for.
void plan(const Rank& rank, const Script& script, Manager& manager, const Round& round);

/// All ranks: donors look where their particles are, and tell the manager. Nobody waits for answers.
void balance(Rank& rank, const Script& script, Calculator& calculator, Manager& manager, Round& round);

/// Manager: before it deals births, the cuts that follow from the last frame's proposals.
void take_all_proposals(Rank& rank, const Script& script, Manager& manager);

/// Calculator, for the log: where particles are at the frame's end, per system.
std::vector<Density> densities(const Script& script, const Calculator& calculator);

}  // namespace motes::frame
