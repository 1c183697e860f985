// create, another way: each calculator makes a part of the births, by their numbers, finds their owners, and sends them
// the numbers in a few steps along a ring. Particles depend on their numbers alone, so that owners make them again, and
// they are those that the manager would make.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/births/create.h"

namespace motes::engine {

/// Who creates with that name; "auto" is automatic. Throws std::invalid_argument where there is none.
Births births_named(const std::string& name);

/// Who creates so many births on so many calculators: the quicker of both, as estimated from these numbers alone.
Births quicker_births(std::uint64_t births, std::size_t calculators);

/// Manager: who creates this frame's births, never automatic; nobody where there are none.
std::optional<Births> births_by(const Rank& rank, const Script& script);

/// Manager: whether calculators make this round's births. All of them send and receive then, also what is empty: nobody
/// needs to be told who will.
bool shares_births(const Rank& rank, const Script& script, const Round& round);

/// Calculators: makes this one's part and sends it on its way. One that fails takes part with empty messages.
void share_births(Rank& rank, const Script& script, const Round& round, Newborn& newborn);

/// Makes this calculator's particles of the next group, into the store.
void take_shares(const Rank& rank, const System& system, const BirthGroup& group, Newborn& newborn,
                 particles::Store& store);

}  // namespace motes::engine
