// match_velocity, match_rotational_velocity: each particle takes on the values of those within reach, weighted by
// magnitude / (r^2 + epsilon) (McAllister 2000, MatchVelocity). McAllister's sums are unstable if weights add up to
// more than 2 in a step; here their sum is limited to 1.
#pragma once

#include "interactions/sweep.h"

namespace motes::MOTES_ISA {

/// kValue: the first of the three columns to match.
template <int kValue>
struct Matching {
  Floats reach2, strength, epsilon;

  struct Sums {
    Floats3 at, value, sum{};
    Floats weight{};
    Ints pairs{};

    MOTES_INLINE Sums(const Matching&, const Task& task, std::uint32_t i, std::uint32_t)
        : at(load_column(task.targets.column, interactions::at_x, i)),
          value(load_column(task.targets.column, kValue, i)) {}

    MOTES_INLINE void add(const Matching& law, const Task& task, std::uint32_t j) {
      const float* const* column = task.sources.column;
      const Floats3 r = seen_from(at, column, j);
      const Floats r2 = dot(r, r);
      const Mask seen = (r2 < law.reach2) & (r2 > 0.0f);
      const Floats w = only(seen, law.strength / (r2 + law.epsilon));
      sum = sum + only(seen, difference(value, column, kValue, j) * w);
      weight = weight + w;
      pairs -= seen;
    }

    MOTES_INLINE void finish(const Matching&, const Task& task, const Around&, std::uint32_t i,
                             std::uint32_t last) const {
      const Floats part = 1.0f / max(weight, all(1.0f));
      const Floats3 now = value + sum * part;
      store_lanes3(task.out, i, now, last - i);
      task.stats->pairs += sum_own(task.targets.cells, pairs, i, last);
    }
  };
};

template <int kValue, class Numbers>
MOTES_INLINE void match(const Task& task, const Numbers& n) {
  sweep(task, Matching<kValue>{all(task.reach * task.reach), all(n.magnitude * task.dt), all(n.epsilon)});
}

inline void match_velocity(const Task& task) {
  match<interactions::velocity_x>(task, numbers_of<numbers::match_velocity>(task));
}

inline void match_rotational_velocity(const Task& task) {
  match<interactions::spin_x>(task, numbers_of<numbers::match_rotational_velocity>(task));
}

namespace laws {
inline constexpr interactions::Law match_velocity = {
    .act = MOTES_ISA::match_velocity,
    .reach = [](const double* recorded) { return actions::read_numbers<numbers::match_velocity>(recorded).max_radius; },
};
inline constexpr interactions::Law match_rotational_velocity = {
    .act = MOTES_ISA::match_rotational_velocity,
    .reach =
        [](const double* recorded) {
          return actions::read_numbers<numbers::match_rotational_velocity>(recorded).max_radius;
        },
};
}  // namespace laws

}  // namespace motes::MOTES_ISA
