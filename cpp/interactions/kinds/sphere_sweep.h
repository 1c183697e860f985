// Spheres of one system that touch each other or their ghosts, and walls, by a neighbour list.
#pragma once

#include "interactions/near_pairs.h"
#include "interactions/pair_action.h"
#include "interactions/scratch.h"

namespace motes::interactions {

/// Which spheres a sweep is about.
struct Grouping {
  bool of_clumps = false;  // spheres of clumps get sums of pushes
  bool chosen = false;  // not all particles may change
  int place = 0;  // 1, 2: the first or second of two systems, whose ghosts are all particles of the other

  /// Where not all may change, one end of a pair may remember a touch that the other does not.
  NeighbourList::Kind kind() const {
    return {.ghosts_alone = place != 0, .of_clumps = of_clumps, .near = true, .apart = chosen};
  }
};

class SphereSweep : public PairAction {
 public:
  SphereSweep(const Meeting& meeting, const Grouping& grouping) : PairAction(meeting), grouping_(grouping) {}

  InteractionCounts act(const Agreement& agreed) override;

 private:
  NearPairs& near() { return list_.near(); }
  GrainColumns columns_of_grains(const std::vector<Column>& columns) const;
  void place(const Crowd& crowd, const GrainColumns& grains);
  void build(const Crowd& crowd, const GrainColumns& grains, float reach);
  TouchTask task();
  void apply(std::size_t own);

  const Grouping grouping_;
  const SideList& kept_ = side(0).kept;
  const Ends ends_{*meeting_.periods};
  NeighbourList& list_ = kept_.list != nullptr ? *kept_.list : meeting_.scratch->party[0].list;
};

}  // namespace motes::interactions
