// One action between particles on one rank: what it reads of those that it sees, how far it sees, and what it does to
// this rank's particles. No conversation: copies of other ranks' particles are given.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "actions/action.h"
#include "meetings/kernels.h"
#include "meetings/pairs.h"
#include "particles/store.h"

namespace motes::meetings {

/// A component of an attribute.
struct Component {
  int attribute = 0;
  int component = 0;
};

/// What ranks know of particles of another: as many of each column as there are ids.
struct Copies {
  std::vector<std::uint64_t> ids;
  std::vector<std::vector<float>> columns;  // of read_by()
};

/// What an action reads of those that it sees: position first.
std::vector<Component> read_by(const actions::Action& action);

/// What all ranks agree on before particles meet: maxima over all of them.
struct Extent {
  float radius = 0;         // metres
  float other_radius = 0;   // of the second system
  float displacement = 0;   // metres along an axis, in the step
  float rounding = 0;       // metres: of positions where copies are; see rounding_at
  float masses = 0;         // above 0: some particle has another mass than 1 kg

  bool operator==(const Extent&) const = default;
};

/// What looking ahead may round, for particles next to a cut this far from the origin of space.
constexpr float rounding_at(float cut) { return cut * 0x1p-22f; }

/// Of this rank's particles, but for rounding. `second`: they are of the action's second system.
Extent extent_of(const actions::Action& action, const particles::Store& store, float dt, bool second,
                 threads::Pool& pool);

/// How far apart two particles may be that see each other, at the places where the action looks for them.
float reach_of(const actions::Action& action, const Extent& extent);
/// How far apart they may be now.
double range_of(const actions::Action& action, const Extent& extent);

/// The particles of one system: those of this rank, who is changed of them, and copies of others.
struct Side {
  particles::Store* store = nullptr;
  const Copies* copies = nullptr;
  const std::vector<std::uint8_t>* chosen = nullptr;  // null: all are changed
  std::uint64_t newborn_from = UINT64_MAX;            // collide: ids from here on meet for the first time
  bool adds = false;                                  // collide: its contacts come on top of an earlier one's
};

/// What a meeting saw.
struct Seen {
  std::uint64_t pairs = 0;          // directed: each is counted at both ends
  std::uint32_t most_in_a_cell = 0;
  std::vector<std::uint32_t> dropped[2]{};  // collide: newborn ones in the way of others, ascending
};

/// A script's function of pairs: gives the changes of velocity of their own particles, three numbers each, or none.
using PairProcedure = std::function<std::vector<float>(const PairList& pairs)>;

/// Working memory that is kept from meeting to meeting.
struct Scratch {
  struct Party {
    Cells cells;
    std::vector<float> at[3], copied_at[3];  // where particles will be at the end of the step
    std::vector<float> column[party_columns];
    std::vector<float> out[4];
  };
  Party party[2];
};

/// Calls the procedure of all pairs of this rank, and adds up what it says, pair by pair.
Seen act_on_pairs(const actions::Action& action, const Side& side, const PairProcedure& procedure, Scratch& scratch,
                  threads::Pool& pool);

/// Acts on the particles of one system, or on those of two on both (`sides` of which the second has no store: one).
Seen act(const actions::Action& action, const Extent& extent, float dt, const Side (&sides)[2], Scratch& scratch,
         threads::Pool& pool);

}  // namespace motes::meetings
