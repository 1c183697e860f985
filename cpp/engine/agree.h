// agree: all ranks report to the manager, which answers all: counts, who sends particles to whom, and whether a rank
// failed or recorded another list. Whatever the answer is, all ranks do the same thing next. Ranks put reports together
// on their way up (reports.h), and divide the answer on its way down.
#pragma once

#include "engine/births/create.h"
#include "engine/parts/manager.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Sends this rank's report of a round, with what became known after the last one. Neighbours that balance without the
/// manager decide before it. Collective.
void report(Rank& rank, const Script& script, Calculator& calculator, Round& round, const Newborn& newborn);

/// Manager: hears all reports, and sends the verdict.
void judge(Rank& rank, const Script& script, Manager& manager, Round& round);

/// Receives the verdict and applies it; throws if all agreed to give up. Collective.
void hear_verdict(Rank& rank, Script& script, Round& round);

/// Manager: what it heard goes into the account, when no rank waits for it.
void keep_account(Rank& rank, const Script& script, Manager& manager);
/// Manager: what calculators told the log goes there too. It has to wait for that, and so is asked to while the others
/// act: before it judges again.
void take_tails(Rank& rank, Manager& manager);

}  // namespace motes::engine
