// Who takes part in an interaction on one rank: one or two systems, their ghosts, and what the sub-step's earlier
// interactions left.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "actions/action.h"
#include "interactions/extent.h"
#include "interactions/neighbour_list.h"
#include "interactions/pairs.h"
#include "particles/periods.h"
#include "particles/store.h"
#include "threads/pool.h"

namespace motes::interactions {

struct Scratch;

/// Ghosts: copies of other ranks' particles. Each column has one value per id.
struct Ghosts {
  std::vector<std::uint64_t> ids;
  std::vector<std::vector<float>> columns;  // in the order of PairAction::reads()
  std::vector<std::uint8_t> images;  // in periodic space: which image of its particle each ghost is; else empty
};

/// What an action that counts contacts must know of the sub-step's earlier ones.
struct Collisions {
  std::uint64_t newborn_from = UINT64_MAX;  // ids from here on collide for the first time
  double gravity = 0;  // magnitude of the gravity that precedes the action in the system's list, m/s2
  bool adds = false;   // add to the contacts counted so far
  const std::vector<std::uint8_t>* adds_to = nullptr;  // which particles to add for, by index; null: all

  /// Returns whether the contacts of a particle, given by its index, are added.
  bool adds_for(std::size_t i) const { return adds && (adds_to == nullptr || (*adds_to)[i] != 0); }
};

/// The neighbour list of an action in one system, if it keeps one.
struct SideList {
  NeighbourList* list = nullptr;  // null: it ends with the sub-step
  std::uint32_t law = 0;  // number of the action among those of the system's list that keep one, from 0
  bool holds = false;     // the lists of all ranks are still valid
  float skin = 0;         // of the next list, if they are not, m
};

/// One system in an interaction: this rank's own particles, which of them may change, and ghosts.
struct Side {
  std::size_t system = 0;                    // index
  const actions::Action* action = nullptr;  // as in the system's own list
  particles::Store* store = nullptr;
  const Ghosts* ghosts = nullptr;
  const std::vector<std::uint8_t>* chosen = nullptr;  // which particles may change, by index; null: all
  std::uint64_t everywhere = 0;  // upper bound on the system's particles on all ranks, the same on all of them
  Collisions collisions;
  SideList kept;
};

/// A sub-step.
struct SubStep {
  std::uint32_t number = 0;  // since the run's start, from 1
  float dt = 0;              // s
  double time = 0;           // its start, seconds of the animation
  float start = 0, end = 1;  // its start and end, as fractions of the frame
  bool last = false;         // of the frame
};

/// A script's function of pairs: returns the change of velocity, m/s, of each pair's own particle, three numbers per
/// pair, or nothing.
using PairProcedure = std::function<std::vector<float>(const PairList& pairs)>;

/// An interaction on one rank: of the particles of one system, or of those of two with each other.
struct Meeting {
  Side sides[2];
  std::size_t count = 1;
  SubStep step;
  const particles::Periods* periods = nullptr;  // of space
  bool all_here = false;  // this rank owns all particles
  PairProcedure ask_script;
  Scratch* scratch = nullptr;
  threads::Pool* pool = nullptr;
};

/// Returns these columns of own particles and ghosts.
std::vector<Column> columns_of(const std::vector<Component>& read, const Side& side);

/// Returns a side's own particles and ghosts. `at`: their positions; null: those that the columns begin with.
Crowd crowd_of(const Side& side, const std::vector<Column>& columns);

}  // namespace motes::interactions
