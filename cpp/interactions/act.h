// One action between particles on one rank: what it reads of those that it sees, how far it sees, and what it does to
// this rank's particles. No conversation: ghosts of other ranks' particles are given.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "actions/action.h"
#include "interactions/extent.h"
#include "interactions/kernels.h"
#include "interactions/pairs.h"
#include "particles/store.h"

namespace motes::interactions {

/// What ranks know of particles of another: as many of each column as there are ids.
struct Ghosts {
  std::vector<std::uint64_t> ids;
  std::vector<std::vector<float>> columns;  // of read_by()
};

/// The particles of one system: those of this rank, who is changed of them, and ghosts of others.
struct Side {
  particles::Store* store = nullptr;
  const Ghosts* ghosts = nullptr;
  const std::vector<std::uint8_t>* chosen = nullptr;  // null: all are changed
  std::uint64_t newborn_from = UINT64_MAX;            // collide: ids from here on meet for the first time
  bool adds = false;                                  // collide: its contacts come on top of an earlier one's
  const std::vector<std::uint8_t>* adds_to = nullptr;  // of these; null: of all
  std::uint32_t now = 0;                              // contact: the number of the sub-step, from 1 on
  bool last = false;                                  // sub-step of the frame: overlaps are looked at
};

/// What the action reads, in the order of read_by(): of own particles, and of ghosts.
std::vector<Column> columns_of(const actions::Action& action, const Side& side);

/// What an interaction saw.
struct Seen {
  std::uint64_t pairs = 0;          // directed: each is counted at both ends
  std::uint32_t most_in_a_cell = 0;
  bool softened = false;            // contact: springs were stiffer than the step allows
  float overlap_99 = 0;             // of spheres that touch, in parts of both radii; see overlap.h
  std::vector<std::uint32_t> dropped[2]{};  // collide: newborn ones in the way of others, ascending
};

/// A script's function of pairs: gives the changes of velocity of their own particles, three numbers each, or none.
using PairProcedure = std::function<std::vector<float>(const PairList& pairs)>;

/// Working memory that is kept from interaction to interaction.
struct Scratch {
  struct Party {
    Cells cells;
    std::vector<float> at[3], copied_at[3];  // where particles will be at the end of the step
    std::vector<float> column[party_columns];
    std::vector<float> out[kMostResults];
  };
  Party party[2];
};

/// Calls the procedure of all pairs of this rank, and adds up what it says, pair by pair.
Seen act_on_pairs(const actions::Action& action, const Side& side, const PairProcedure& procedure, Scratch& scratch,
                  threads::Pool& pool);

/// Acts on the particles of one system, or on those of two on both (`sides` of which the second has no store: one).
Seen act(const actions::Action& action, const Extent& extent, float dt, const Side (&sides)[2], Scratch& scratch,
         threads::Pool& pool);

}  // namespace motes::interactions
