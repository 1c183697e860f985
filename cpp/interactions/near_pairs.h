// Near pairs: those of a neighbour list that can touch within the next few sub-steps, found by where grains are and how
// fast they move towards each other. Only these are looked at in each sub-step. Each rank finds its own: which pairs
// are near does not show in any result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "interactions/grains.h"
#include "interactions/kernels.h"
#include "threads/pool.h"

namespace motes::interactions {

/// Near pairs, and which of them each place is in.
struct NearLinks {
  std::vector<std::uint32_t> first, second, pair;  // places, and number in the neighbour list
  std::vector<std::uint32_t> begin, pushes, pushed;  // see grains.h

  /// A near pair, as one of its ends sees it.
  struct Seen {
    std::uint32_t pair, other;
    bool back;  // this end is the pair's second: what has a direction has the opposite one
  };
  /// Calls visit(Seen) for the near pairs of a place, by the others' ids.
  template <class Visit>
  void each(std::size_t place, const Visit& visit) const {
    for (std::uint32_t k = begin[place]; k < begin[place + 1]; ++k) {
      const std::uint32_t n = (pushes[k] - 1) / 2;
      const bool back = (pushes[k] & 1) == 0;
      visit(Seen{pair[n], back ? first[n] : second[n], back});
    }
  }
};

class NearPairs {
 public:
  explicit NearPairs(const Kernels& kernels = interactions::kernels()) : kernels_(&kernels) {}

  const Kernels& kernels() const { return *kernels_; }

  /// The grains of a neighbour list in a sub-step.
  struct Placing {
    const Cells& cells;
    const GrainColumns& columns;
    std::size_t own, ghosts;
    const Ends& ends;
  };
  /// Forgets near pairs, since the neighbour list is about to be replaced.
  void forget() { known_ = false; }
  /// Arranges the grains in the order of the cells.
  void place(const Placing& placing, threads::Pool& pool);
  const Grain* grains() const { return grains_.data(); }

  /// Lets grains push each other. The task has the listed pairs and the law. Returns twice the number of touching
  /// pairs, counting ends at other ranks' grains not.
  std::uint64_t act(TouchTask task, float reach, const Cells& cells, threads::Pool& pool);
  /// Returns what act() computed, by place.
  GrainPush* out() { return out_.data(); }

  const NearLinks& links() const { return links_; }
  /// Forgets near pairs and returns them.
  NearLinks take() {
    forget();
    return std::move(links_);
  }

  /// Returns the 99th percentile of overlaps of touching pairs, relative to the sum of both radii; 0 if none touch.
  /// Samples about a thousand grains.
  float overlap_99(const Cells& cells, std::size_t own, const Ends& ends) const;

 private:
  void find(TouchTask task, float reach, const std::vector<std::size_t>& parts, threads::Pool& pool);

  const Kernels* kernels_;
  std::vector<Grain> grains_;
  std::vector<Course> courses_;
  NearLinks links_;
  std::vector<std::uint32_t> touched_;
  std::vector<GrainPush> push_, out_;
  std::uint32_t count_ = 0;
  bool known_ = false, stray_ = false;
  float age_ = 0;  // of the courses, sub-steps
  float skin_ = 0;  // m
};

}  // namespace motes::interactions
