// Ghosts in messages: chosen anew, with ids, or those that are kept, of which only columns that changed travel.
#pragma once

#include <cstdint>
#include <vector>

#include "actions/action.h"
#include "base/bytes.h"
#include "domains/domains.h"
#include "engine/state/kept_ghosts.h"
#include "interactions/act.h"
#include "particles/store.h"

namespace motes::engine {

/// Returns the distance of two boxes along the axis where it is largest, m.
double gap(const domains::Box& a, const domains::Box& b);
/// Returns the distance of a point from the box, m; infinite for NaN, which may belong to any calculator.
double outside(const domains::Box& box, const float (&x)[3]);

/// Appends ghosts of these particles: ids, then what the action reads, column by column. `second`: of the second of two
/// systems.
void put_ghosts(const actions::Action& action, bool second, const particles::Store& store,
                const std::vector<std::uint32_t>& chosen, base::Bytes& out);
/// Reads ghosts behind those that are there; returns how many.
std::uint64_t take_ghosts(base::Reader& in, const actions::Action& action, bool second, interactions::Ghosts& ghosts);

/// Appends, of the ghosts that a calculator keeps of this one, the columns that have changed since they were sent:
///
///     u32 mask | column, column, ...     bit c: column c of what the action reads follows (31: all from there on), one
///     float per ghost
///
/// Returns the number of ghosts.
std::uint64_t put_changes(const actions::Action& action, const particles::Store& store, int target, KeptGhosts& kept,
                          base::Bytes& out);
/// Reads what put_changes has written on another calculator; returns the number of ghosts.
std::uint64_t take_changes(base::Reader& in, int source, KeptGhosts& kept);

/// Finds whose ghosts those here are, and so in which order their owners will send them.
void find_owners(const domains::Domains& domains, KeptGhosts& kept);
/// Puts indices of particles in the order of ids.
void sort_by_id(const particles::Store& store, std::vector<std::uint32_t>& indices);

}  // namespace motes::engine
