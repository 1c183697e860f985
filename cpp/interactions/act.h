// Performs one action between particles on this rank's particles. Does not communicate: the caller provides the ghosts.
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
#include "interactions/wall_sums.h"
#include "particles/store.h"

namespace motes::interactions {

/// Ghosts: copies of other ranks' particles. Each column has one value per id.
struct Ghosts {
  std::vector<std::uint64_t> ids;
  std::vector<std::vector<float>> columns;  // in the order of read_by()
  std::vector<std::uint8_t> images;  // in periodic space: which image of its particle each ghost is; else empty
};

/// One system in an interaction: this rank's own particles, which of them may change, and ghosts.
struct Side {
  particles::Store* store = nullptr;
  const Ghosts* ghosts = nullptr;
  const std::vector<std::uint8_t>* chosen = nullptr;  // which particles may change, by index; null: all
  std::uint64_t newborn_from = UINT64_MAX;  // collide: ids from here on are newborn
  double gravity = 0;  // collide: magnitude of the gravity in the system's list, m/s2
  bool adds = false;  // collide: add to the contacts counted by an earlier action
  const std::vector<std::uint8_t>* adds_to = nullptr;  // which particles to add for; null: all
  NeighbourList* list = nullptr;  // contact: the kept neighbour list of this law; null: the scratch's
  std::uint32_t law = 0;  // contact: number of this law among those with neighbour lists, from 0
  bool kept = false;  // contact: all ranks' lists are still valid in this sub-step
  float skin = 0;  // contact: skin of the next list, if not kept, m
  std::uint32_t now = 0;  // contact: number of the sub-step, from 1
  float start = 0, end = 1;  // contact: part of the frame that the sub-step covers, for moving walls
  bool of_clumps = false;  // contact: the particles are spheres of clumps and get sums of pushes: see clumps.h
  int place = 0;  // contact: 1, 2: the first or second of two systems, whose ghosts are all particles of the other
  bool last = false;  // last sub-step of the frame: measure overlaps, write touches to the store
};

/// Returns the columns that the action reads, of own particles and ghosts, in the order of read_by(). `second`: the
/// side is the second of two systems.
std::vector<Column> columns_of(const actions::Action& action, const Side& side, bool second = false);

/// Returns the kind of neighbour list that an action needs. `second`: the side is the second of two systems; its list
/// only records positions.
NeighbourList::Kind list_kind(const actions::Action& action, const Side& side, bool second = false);

/// Statistics of an interaction.
struct InteractionCounts {
  std::uint64_t pairs = 0;  // counted at both ends
  std::uint32_t most_in_a_cell = 0;
  float overlap_99 = 0;  // of touching spheres, relative to the sum of both radii: see overlap.h
  std::vector<std::uint32_t> dropped[2]{};  // collide: indices of newborn particles to remove, ascending
  WallSums walls{};  // contact: forces on its walls
};

/// A script's function of pairs: returns the change of velocity, m/s, of each pair's own particle, three numbers per
/// pair, or nothing.
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

  // For laws written by scripts (scripted.h).
  struct Compiled {
    std::vector<expressions::Expression> values;
    expressions::Formula formula;
  };
  struct ScriptedMemory {
    std::vector<std::uint64_t> ids;  // ids of the other system: own particles, then ghosts
    std::vector<std::vector<float>> copied, column, out;
    std::vector<float> radius;
  };
  std::vector<Compiled> formulas;
  ScriptedMemory scripted;

  std::shared_ptr<ExpandedClumps> clumps;  // passed from clumps_hold() to act_on_clumps(): see clumps.h
  std::unique_ptr<Scratch> second;  // contact: of the second of two systems

  /// Returns the working memory of one of two systems, 0 or 1, in contact.
  Scratch& of(std::size_t side) {
    if (side == 0) return *this;
    if (second == nullptr) second = std::make_unique<Scratch>();
    return *second;
  }
};

/// Returns whether a side's kept list is still valid for this rank's own particles: see NeighbourList::holds.
bool list_holds(const actions::Action& action, const Side& side, bool second, Scratch& scratch, threads::Pool& pool);

/// Calls the procedure with all pairs of this rank and adds up its changes in the order of the pairs.
InteractionCounts act_on_pairs(const actions::Action& action, const Side& side, const PairProcedure& procedure,
                               Scratch& scratch, threads::Pool& pool);

/// Acts on the particles of one system, or of two on each other. For one system, sides[1].store is null.
InteractionCounts act(const actions::Action& action, const Extent& extent, float dt, const Side (&sides)[2],
                      Scratch& scratch, threads::Pool& pool);

}  // namespace motes::interactions
