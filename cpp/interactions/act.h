// Performs one action between particles on this rank's particles. Does not communicate: ghosts of other ranks'
// particles are given.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "actions/action.h"
#include "interactions/extent.h"
#include "interactions/kernels.h"
#include "interactions/neighbour_list.h"
#include "interactions/pairs.h"
#include "particles/store.h"

namespace motes::interactions {

/// Ghosts: copies of other ranks' particles. Each column has one value per id.
struct Ghosts {
  std::vector<std::uint64_t> ids;
  std::vector<std::vector<float>> columns;  // in the order of read_by()
  std::vector<std::uint8_t> images;  // in periodic space: which of its particle's places each is at; else empty
};

/// The particles of one system: this rank's own, which of them are changed, and ghosts.
struct Side {
  particles::Store* store = nullptr;
  const Ghosts* ghosts = nullptr;
  const std::vector<std::uint8_t>* chosen = nullptr;  // null: all are changed
  std::uint64_t newborn_from = UINT64_MAX;            // collide: ids from here on are newborn
  bool adds = false;                                  // collide: add contacts to those of an earlier action
  const std::vector<std::uint8_t>* adds_to = nullptr;  // which particles to add for; null: all
  NeighbourList* list = nullptr;                      // contact: the kept list of this law; null: the scratch's
  std::uint32_t law = 0;                              // contact: its number among those of the list, from 0 on
  bool kept = false;                                  // contact: the list holds for this sub-step, on all ranks
  float skin = 0;                                     // contact: else, of the next list, metres
  std::uint32_t now = 0;                              // contact: the number of the sub-step, from 1 on
  float start = 0, end = 1;                           // contact: which part of the frame it is, for walls that move
  bool of_clumps = false;  // contact: they are spheres of clumps, and get sums of pushes: see clumps.h
  bool last = false;  // last sub-step of the frame: measure overlaps, write touches to the store
};

/// Returns the columns that the action reads, in the order of read_by(), of own particles and ghosts. `second`: of the
/// second of two systems.
std::vector<Column> columns_of(const actions::Action& action, const Side& side, bool second = false);

/// What the list of an action is for. `second`: of the second of two systems, which only notes where these are.
NeighbourList::Kind list_kind(const actions::Action& action, const Side& side, bool second = false);

/// Statistics of an interaction.
struct InteractionCounts {
  std::uint64_t pairs = 0;  // counted at both ends
  std::uint32_t most_in_a_cell = 0;
  float overlap_99 = 0;  // of touching spheres, relative to the sum of both radii: see overlap.h
  std::vector<std::uint32_t> dropped[2]{};  // collide: indices of newborn particles to remove, ascending
};

/// A script's function of pairs: returns the change of velocity of each pair's own particle, three numbers each, or
/// nothing.
using PairProcedure = std::function<std::vector<float>(const PairList& pairs)>;

class ExpandedClumps;

/// Working memory, reused from interaction to interaction.
struct Scratch {
  struct Party {
    Cells cells;
    NeighbourList list;
    std::vector<float> at[3], copied_at[3];  // predicted positions at the end of the step
    std::vector<float> column[party_columns];
    std::vector<float> out[kMostResults];
  };
  Party party[2];

  // Of laws that scripts write (scripted.h).
  struct Compiled {
    std::vector<expressions::Expression> values;
    expressions::Formula formula;
  };
  struct ScriptedMemory {
    std::vector<std::uint64_t> ids;  // of another system: its own particles, then ghosts
    std::vector<std::vector<float>> copied, column, out;
    std::vector<float> radius;
  };
  std::vector<Compiled> formulas;
  ScriptedMemory scripted;

  std::shared_ptr<ExpandedClumps> clumps;  // between clumps_hold() and act_on_clumps(): see clumps.h
};

/// Tells whether a side's kept list holds as far as this rank's own particles go: see NeighbourList::holds.
bool list_holds(const actions::Action& action, const Side& side, bool second, Scratch& scratch, threads::Pool& pool);

/// Calls the procedure with all pairs of this rank and adds up its changes in the order of the pairs.
InteractionCounts act_on_pairs(const actions::Action& action, const Side& side, const PairProcedure& procedure,
                               Scratch& scratch, threads::Pool& pool);

/// Acts on the particles of one system, or of two on each other. For one system, sides[1].store is null.
InteractionCounts act(const actions::Action& action, const Extent& extent, float dt, const Side (&sides)[2],
                      Scratch& scratch, threads::Pool& pool);

}  // namespace motes::interactions
