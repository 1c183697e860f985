// Ghosts in messages: chosen anew, with ids, or those that are kept, of which only columns that changed travel.
#pragma once

#include <cstdint>
#include <vector>

#include "actions/action.h"
#include "base/bytes.h"
#include "domains/domains.h"
#include "engine/act/images.h"
#include "engine/state/kept_ghosts.h"
#include "interactions/act.h"
#include "particles/store.h"

namespace motes::engine {

/// Returns the distance of two boxes along the axis where it is largest, m.
double gap(const domains::Box& a, const domains::Box& b);
/// Returns the distance of a point from the box, m; infinite for NaN, which may belong to any calculator.
double outside(const domains::Box& box, const float (&x)[3]);
/// Tells whether a point is at most so far from one of the boxes around a domain, m.
bool within(const domains::BoxCover& cover, const float (&x)[3], double range);

/// Particles that become ghosts, each at one of its places.
struct Chosen {
  std::vector<std::uint32_t> particles;  // indices
  std::vector<std::uint8_t> images;      // numbers of places; empty where space is not periodic

  std::size_t size() const { return particles.size(); }
};

/// Appends ghosts of these particles: ids, then what the action reads, column by column, then the numbers of their
/// places. Their columns are those of the particles themselves. `second`: of the second of two systems.
void put_ghosts(const actions::Action& action, bool second, const particles::Store& store, const Chosen& chosen,
                base::Bytes& out);
/// Reads ghosts behind those that are there; returns how many. `images`: whether space is periodic.
std::uint64_t take_ghosts(base::Reader& in, const actions::Action& action, bool second, bool images,
                          interactions::Ghosts& ghosts);
/// Moves ghosts, which stand where their particles are, to their places.
void place_ghosts(const Images& images, interactions::Ghosts& ghosts);

/// Appends, of the ghosts that a calculator keeps of this one, the columns that have changed since they were sent:
///
///     u32 mask | column, column, ...     bit c: column c of what the action reads follows (31: all from there on), one
///     float per ghost
///
/// Returns the number of ghosts.
std::uint64_t put_changes(const actions::Action& action, bool second, const particles::Store& store, int target,
                          KeptGhosts& kept, base::Bytes& out);
/// Reads what put_changes has written on another calculator; returns the number of ghosts.
std::uint64_t take_changes(base::Reader& in, int source, const Images& images, KeptGhosts& kept);

/// Finds whose ghosts those here are, and so in which order their owners will send them. They have not been placed yet.
void find_owners(const domains::Domains& domains, KeptGhosts& kept);
/// Puts indices of particles in the order of ids; those of the same particle keep their order.
void sort_by_id(const particles::Store& store, std::vector<std::uint32_t>& indices);

}  // namespace motes::engine
