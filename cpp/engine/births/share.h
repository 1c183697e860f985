// create, another way: each calculator makes a part of the births, by their numbers, finds their owners, and sends them
// the numbers in a few steps along a ring. Particles depend on their numbers alone, so that owners make them again, and
// they are those that the manager would make.
#pragma once

#include "engine/births/create.h"

namespace motes::engine {

/// Manager: whether calculators make this round's births. All of them send and receive then, also what is empty: nobody
/// needs to be told who will.
bool shares_births(const Rank& rank, const Script& script, const Round& round);

/// Calculators: makes this one's part and sends it on its way. One that fails takes part with empty messages.
void share_births(Rank& rank, const Script& script, const Round& round, Newborn& newborn);

/// Makes this calculator's particles of the next group, into the store.
void take_shares(const Rank& rank, const System& system, const BirthGroup& group, Newborn& newborn,
                 particles::Store& store);

}  // namespace motes::engine
