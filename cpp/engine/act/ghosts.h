// Ghosts in messages: newly chosen ghosts with their ids, or the changed columns of kept ghosts.
#pragma once

#include <cstdint>
#include <vector>

#include "base/bytes.h"
#include "domains/domains.h"
#include "engine/act/images.h"
#include "engine/state/kept_ghosts.h"
#include "interactions/sides.h"
#include "particles/store.h"

namespace motes::engine {

/// Returns the distance of two boxes along the axis on which it is largest, m.
double gap(const domains::Box& a, const domains::Box& b);
/// Returns the distance of a point from the box along the axis on which it is largest, m; infinite for NaN, which may
/// belong to any calculator.
double outside(const domains::Box& box, const float (&x)[3]);
/// Returns whether a point is at most `range` metres from one of the boxes that cover a domain.
bool within(const domains::BoxCover& cover, const float (&x)[3], double range);

/// Particles to send as ghosts, each at one of its places (see Images).
struct Chosen {
  std::vector<std::uint32_t> particles;  // indices
  std::vector<std::uint8_t> images;      // numbers of places; empty if space is not periodic

  std::size_t size() const { return particles.size(); }
};

/// Appends ghosts of these particles: ids, then the columns that the action reads, then the numbers of their places.
/// The columns hold the particles' own positions.
void put_ghosts(const std::vector<interactions::Component>& read, const particles::Store& store, const Chosen& chosen,
                base::Bytes& out);
/// Reads the ghosts of a message and appends them to `ghosts`; returns how many. `columns`: how many the action reads;
/// `images`: whether space is periodic.
std::uint64_t take_ghosts(base::Reader& in, std::size_t columns, bool images, interactions::Ghosts& ghosts);
/// Moves ghosts from their particles' positions to their places.
void place_ghosts(const Images& images, interactions::Ghosts& ghosts);

/// Appends the columns that have changed since they were last sent, of the ghosts that calculator `target` keeps:
///
///     u32 mask | column | column | ...
///
/// Bit c of the mask: column c of those that the action reads follows, one float per ghost; bit 31: all columns from 31
/// on. Returns the number of ghosts.
std::uint64_t put_changes(const std::vector<interactions::Component>& read, const particles::Store& store, int target,
                          KeptGhosts& kept, base::Bytes& out);
/// Reads the message of put_changes from calculator `source`; returns the number of ghosts.
std::uint64_t take_changes(base::Reader& in, int source, const Images& images, KeptGhosts& kept);

/// Finds the owners of ghosts, and the order in which each will send them. Call before place_ghosts.
void find_owners(const domains::Domains& domains, KeptGhosts& kept);
/// Sorts indices of particles by id; equal ids keep their order.
void sort_by_id(const particles::Store& store, std::vector<std::uint32_t>& indices);

}  // namespace motes::engine
