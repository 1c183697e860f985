// Actions between particles, on one rank: one class per family (kinds/), which finds out who sees whom; what they do to
// each other is the law of a kernel (laws/). None communicates: the engine carries their numbers and ghosts around.
//
// Which law goes which way:
//
//   action                    family (kinds/)   sees by                                     computed by
//   match_*, fluid            Sweeping     -+
//   collide                   Colliding    -+-> cell list, nine rows of cells (sweep.h) --> laws/law_*.h
//   gravitate                 Sweeping     -+
//     with far="cells"        ByCells      ---> cell list; far cells of a pyramid --------> pull.h
//   pairs                     Calling      ---> cell list --------------------------------> the script's function
//   contact                   Touching     -+-> neighbour list of spheres, of these the
//                                           |   near pairs, and walls --------------------> touch_lanes.h, wall_lanes.h
//     of clumps                            -+     (clumps: expanded, then summed: clump_lanes.h)
//   interact                  Scripted     ---> neighbour list ---------------------------> law_interact.h, formulas
//   tie                       Tying        ---> the ties' ends, at any distance ----------> kinds/tying.cpp
//   follow                    none         ---> messages to the keepers of ids -----------> engine/act/follow.h
//
// Who agrees on what with whom, in each interaction:
//
//   calculator                                            with
//   own()       what its particles may reach       --->   all: the maximum of each number, with a failure flag
//   range()     the same on all, from the maxima
//               migrants, ghosts within range      <-->   those whose domains are within range
//   to_add()    integers, such as masses of cells  <-->   all: their sums
//   act()       changes this rank's own particles
//
// All calculators must compute the same range and skin, or one waits for ghosts that another never sends. Hence both
// depend only on agreed numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "interactions/sides.h"
#include "interactions/wall_sums.h"

namespace motes::interactions {

/// What all ranks agree on before an interaction: of each number, the maximum over all ranks.
struct Agreement {
  float outside = 0;  // largest distance of a particle from its domain, m
  Extent extent;
  float worn = 0;  // 1: the neighbour lists of a rank no longer hold
  Wear wear;  // of neighbour lists
  std::vector<float> more;  // the family's own, equally many on all ranks: see PairAction::own
  std::vector<std::int64_t> sums;  // of PairAction::to_add, once they are added up
};

template <class Visitor>
constexpr void fields(Visitor& visit, Agreement& agreement) {
  visit(agreement.outside, agreement.extent, agreement.worn, agreement.wear, agreement.more);
}

/// Statistics of an interaction.
struct InteractionCounts {
  std::uint64_t pairs = 0;  // counted at both ends
  std::uint32_t most_in_a_cell = 0;
  float overlap_99 = 0;  // of touching spheres, relative to the sum of both radii: see overlap.h
  std::vector<std::uint32_t> dropped[2]{};  // indices of newborn particles to remove, by side, ascending
  WallSums walls{};  // forces on the action's walls
};

/// One action between particles, in one sub-step on one rank.
class PairAction {
 public:
  explicit PairAction(const Meeting& meeting) : meeting_(meeting) {}
  PairAction(const PairAction&) = delete;
  PairAction& operator=(const PairAction&) = delete;
  virtual ~PairAction() = default;

  /// Returns the name of the function that scripts call, for messages.
  std::string name() const { return actions::call_of(action().kind); }

  /// Returns the columns that the action reads of a side's particles as sources, position first; none if it has no
  /// sources there.
  virtual std::vector<Component> reads(std::size_t side) const;
  /// Returns those of some particles of a side, as indices, that others may have to see.
  virtual std::vector<std::uint32_t> sources(std::size_t side, std::vector<std::uint32_t> particles) const;
  /// How the action sees across the ends of periodic space: images of particles as ghosts; each particle once, at its
  /// own place, since the action finds the nearest image, within half a period or of partners at any distance; or not
  /// at all.
  enum class AcrossEnds : std::uint8_t { images, nearest, nearest_partners, refused };
  virtual AcrossEnds across_ends() const { return AcrossEnds::images; }

  /// Returns whether a side's kept list is still valid for this rank's own particles: see NeighbourList::holds.
  virtual bool holds(std::size_t) { return false; }

  /// Measures this rank's particles: what it contributes to the agreement. Distances from domains, and whether lists
  /// hold, are added by the engine.
  virtual Agreement own();
  /// Returns the largest distance, m, at which two particles interact, at the (predicted) positions the action uses.
  virtual float reach(const Agreement& agreed) const;
  /// Returns the largest current distance, m, at which two particles may interact.
  virtual double range(const Agreement& agreed) const;
  /// Returns how many integers the ranks must add up before they act, and this rank's.
  virtual std::size_t to_add(const Agreement&) const { return 0; }
  virtual std::vector<std::int64_t> own_to_add(const Agreement&) const { return {}; }

  /// Acts on this rank's particles.
  virtual InteractionCounts act(const Agreement& agreed) = 0;

  /// Returns the fewest sub-steps per frame of `frame_s` seconds with which springs are not softened, even between the
  /// two lightest particles; 0 if there are none.
  virtual float substeps(const Agreement&, double) const { return 0; }

 protected:
  const Side& side(std::size_t number) const { return meeting_.sides[number]; }
  const actions::Action& action(std::size_t number = 0) const { return *meeting_.sides[number].action; }
  /// Returns the other system's number, or the same if there is only one.
  std::size_t seen_by(std::size_t number) const { return meeting_.count == 2 ? 1 - number : number; }

  const Meeting& meeting_;
};

/// Asks a kept list whether it still holds. `radii`: of the side's own particles; `periods`: see NeighbourList::holds.
bool list_holds(const Side& side, const NeighbourList::Kind& kind, const Radii& radii, const Meeting& meeting,
                const particles::Periods& periods = {});

}  // namespace motes::interactions
