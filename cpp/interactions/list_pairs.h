// Builds a neighbour list in two passes: counts the pairs of each target, then writes them, target by target.
#pragma once

#include "interactions/sweep.h"

namespace motes::MOTES_ISA {

/// Lists pairs whose surfaces are closer than the skin. A particle without a radius has none.
template <bool kWrite>
struct Listing {
  const interactions::ListTask& list;

  struct Sums {
    std::uint32_t first;
    Floats3 at;
    Floats own;
    Ints count{};
    std::uint32_t next[kLanes];

    MOTES_INLINE Sums(const Listing& law, const Task& task, std::uint32_t i, std::uint32_t last)
        : first(i), at(load_column(task.targets.column, interactions::at_x, i)),
          own(load(task.targets.column[interactions::radius] + i)) {
      for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
        const bool is_own = i + lane < last && task.targets.cells.order[i + lane] < task.targets.cells.own;
        if (!is_own) own[lane] = 0;
        if (kWrite) next[lane] = is_own ? law.list.begin[i + lane] : 0;
      }
    }

    MOTES_INLINE Mask near(const Listing& law, const Task& task, std::uint32_t j) const {
      const float* const* column = task.sources.column;
      const Floats3 r = seen_from(at, column, j);
      const float other = column[interactions::radius][j];
      const Floats reach = own + other + law.list.skin;
      return (dot(r, r) < reach * reach) & (own > 0.0f) & (all(other) > 0.0f);
    }

    MOTES_INLINE bool sees(const Listing& law, const Task& task, std::uint32_t j) const {
      return any(near(law, task, j));
    }

    MOTES_INLINE void add(const Listing& law, const Task& task, std::uint32_t j) {
      if (law.list.ghosts_alone && task.sources.cells.order[j] < task.sources.cells.own) return;
      const Mask seen = near(law, task, j);
      if (!kWrite) {
        count -= seen;
        return;
      }
      for (unsigned left = bits_of(seen); left != 0; left &= left - 1) {
        const auto lane = static_cast<std::uint32_t>(__builtin_ctz(left));
        if (first + lane != j) law.list.second[next[lane]++] = j;
      }
    }

    // The count includes the particle itself, unless only ghosts are counted.
    MOTES_INLINE void finish(const Listing& law, const Task&, const Around&, std::uint32_t i, std::uint32_t last) {
      for (std::uint32_t k = i; !kWrite && k < last; ++k) {
        const std::int32_t itself = law.list.ghosts_alone ? 0 : 1;
        law.list.count[k] = count[k - i] > itself ? static_cast<std::uint32_t>(count[k - i] - itself) : 0;
      }
    }
  };
};

inline void list_pairs(const interactions::ListTask& list) {
  Task task;
  task.targets = task.sources = list.spheres;
  task.first_row = list.first_row;
  task.last_row = list.last_row;
  list.second == nullptr ? sweep(task, Listing<false>{list}) : sweep(task, Listing<true>{list});
}

}  // namespace motes::MOTES_ISA
