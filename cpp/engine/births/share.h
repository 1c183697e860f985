// create by calculators: each calculator creates a part of the births, finds their owners, and sends the births'
// numbers to the owners in a few steps along a ring. Particles depend only on their numbers, so the owners create them
// again, the same as if the manager had created them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/births/create.h"

namespace motes::engine {

/// Returns the enumerator of a name; "auto" is Births::automatic. Throws std::invalid_argument for unknown names.
Births births_named(const std::string& name);

/// Returns the quicker way to create `births` particles on `calculators` calculators, estimated only from these
/// numbers.
Births quicker_births(std::uint64_t births, std::size_t calculators);

/// Manager: returns who creates this frame's births, never automatic; nothing if there are no births.
std::optional<Births> births_by(const Rank& rank, const Script& script);

/// Manager: tells whether calculators create this round's births. Then all of them exchange messages, even empty ones,
/// so no rank needs to announce its messages.
bool shares_births(const Rank& rank, const Script& script, const Round& round);

/// Creates this calculator's part of the births and exchanges their numbers along the ring. A calculator that fails
/// takes part with empty messages. Collective over calculators.
void share_births(Rank& rank, const Script& script, const Round& round, Newborn& newborn);

/// Creates this calculator's particles of the next group in the store.
void take_shares(const Rank& rank, const System& system, const BirthGroup& group, Newborn& newborn,
                 particles::Store& store);

}  // namespace motes::engine
