// gravitate: each particle is attracted by all others within reach, with magnitude / (r^2 + epsilon) (McAllister 2000,
// Gravitate).
#pragma once

#include "interactions/sweep.h"

namespace motes::MOTES_ISA {

struct Gravitation {
  Floats reach2, strength, epsilon;

  struct Sums {
    Floats3 at, sum{};
    Ints pairs{};

    MOTES_INLINE Sums(const Gravitation&, const Task& task, std::uint32_t i, std::uint32_t)
        : at(load_column(task.targets.column, interactions::at_x, i)) {}

    MOTES_INLINE void add(const Gravitation& law, const Task& task, std::uint32_t j) {
      const Floats3 r = seen_from(at, task.sources.column, j);
      const Floats r2 = dot(r, r);
      const Mask seen = (r2 < law.reach2) & (r2 > 0.0f);
      sum = sum + only(seen, r * (law.strength / (sqrt(r2) * (r2 + law.epsilon))));
      pairs -= seen;
    }

    MOTES_INLINE void finish(const Gravitation&, const Task& task, const Around&, std::uint32_t i,
                             std::uint32_t last) const {
      store_lanes3(task.out, i, sum, last - i);
      task.stats->pairs += sum_own(task.targets.cells, pairs, i, last);
    }
  };
};

inline void gravitate(const Task& task) {
  const auto n = numbers_of<numbers::gravitate>(task);
  sweep(task, Gravitation{all(task.reach * task.reach), all(n.magnitude * task.dt), all(n.epsilon)});
}

namespace laws {
inline constexpr interactions::Law gravitate = {
    .act = MOTES_ISA::gravitate,
    .reach = [](const double* recorded) { return actions::read_numbers<numbers::gravitate>(recorded).max_radius; },
    .adds = true,
};
}  // namespace laws

}  // namespace motes::MOTES_ISA
