// agree: all ranks report to the manager, which answers with counts, who sends particles to whom, and whether a rank
// failed or recorded a different list. All ranks get the same answer, so they all take the same next step. Reports are
// merged on their way up the tree (reports.h), and the answer is split on its way down.
#pragma once

#include "engine/births/create.h"
#include "engine/parts/manager.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Sends this rank's report of a round, with the tail of the last frame. Neighbours that balance without the manager
/// decide first. Collective.
void report(Rank& rank, const Script& script, Calculator& calculator, Round& round, const Newborn& newborn);

/// Manager: receives all reports and sends the verdict.
void judge(Rank& rank, const Script& script, Manager& manager, Round& round);

/// Receives the verdict and applies it; throws if all ranks give up. Collective.
void hear_verdict(Rank& rank, Script& script, Round& round);

/// Manager: adds the judged rounds to the account. Call when no rank waits for the manager.
void keep_account(Rank& rank, const Script& script, Manager& manager);
/// Manager: adds the ranks' tails to the account. It may have to wait for them, so call it while the others act, before
/// the next judge().
void take_tails(Rank& rank, Manager& manager);

}  // namespace motes::engine
