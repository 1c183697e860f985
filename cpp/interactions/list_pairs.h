// Builds a neighbour list in two passes: counts the pairs of each target, then writes them, target by target.
#pragma once

#include "interactions/displacements.h"
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

    MOTES_INLINE unsigned sees(const Listing& law, const Task& task, std::uint32_t j) const {
      const float* const* column = task.sources.column;
      const Floats3 r = seen_from(at, column, j);
      const float other = column[interactions::radius][j];
      const Floats reach = own + other + law.list.skin;
      return bits_of((dot(r, r) < reach * reach) & (own > 0.0f) & (all(other) > 0.0f));
    }

    MOTES_INLINE void add(const Listing& law, const Task& task, std::uint32_t j, unsigned seen) {
      const bool ghost = task.sources.cells.order[j] >= task.sources.cells.own;
      if (law.list.ghosts_alone && !ghost) return;
      if (law.list.once && !ghost)
        seen &= bits_of((Ints)lane_numbers() < static_cast<std::int32_t>(j) - static_cast<std::int32_t>(first));
      if (!kWrite) {
        count -= mask_of(seen);
        return;
      }
      for (; seen != 0; seen &= seen - 1) {
        const auto lane = static_cast<std::uint32_t>(__builtin_ctz(seen));
        if (first + lane != j) law.list.second[next[lane]++] = j;
      }
    }

    // The count includes the particle itself, unless only ghosts are counted.
    MOTES_INLINE void finish(const Listing& law, const Task&, const Around&, std::uint32_t i, std::uint32_t last) {
      for (std::uint32_t k = i; !kWrite && k < last; ++k) {
        const std::int32_t itself = law.list.ghosts_alone || law.list.once ? 0 : 1;
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

/// Measures how far particles have moved and grown. Those at NaN have no contacts.
inline interactions::Worn measure_wear(const interactions::WearTask& task) {
  const auto column = [](const interactions::Column& of, std::size_t i) __attribute__((always_inline)) {
    return of.own != nullptr ? load(of.own + i) : all(of.value);
  };
  Floats most2{};
  Mask out{};
  for (std::size_t i = task.from; i < task.to; i += kLanes) {
    const Mask here = first_lanes(task.to - i);
    const Floats3 x{column(task.at[0], i), column(task.at[1], i), column(task.at[2], i)};
    const Floats3 before{load(task.listed[0] + i), load(task.listed[1] + i), load(task.listed[2] + i)};
    const Floats3 way = shortest(x - before, *task.ends);
    // NOLINTNEXTLINE(misc-redundant-expression): NaN
    const Mask numbers = (x.x == x.x) & (x.y == x.y) & (x.z == x.z) & here;
    Floats radius = all(task.given);
    if (!(task.given > 0)) radius = max(0.5f * column(task.size, i), Floats{});
    if (task.skips_massless) radius = only(column(task.mass, i) >= interactions::kLeastMass, radius);
    // 0.49 instead of 0.5 leaves room for rounding.
    const Floats left = 0.49f * task.skin - max(radius - load(task.listed_radius + i), Floats{});
    const Floats way2 = dot(way, way);
    most2 = select((way2 > most2) & numbers, way2, most2);
    out |= numbers & ~((left > 0.0f) & (way2 < left * left));
  }
  interactions::Worn worn{0, any(out)};
  for (std::size_t lane = 0; lane < kLanes; ++lane) worn.way2 = most2[lane] > worn.way2 ? most2[lane] : worn.way2;
  return worn;
}

}  // namespace motes::MOTES_ISA
