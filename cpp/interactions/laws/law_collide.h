// collide: spheres push each other apart so that they do not overlap at the end of the step, with Coulomb friction
// (position-based dynamics with one iteration, as an action on velocities: Mueller et al. 2007, "Position based
// dynamics"). Each pair is computed at both ends with opposite signs, so momentum is conserved. Piles are stiff but
// stable because each push is divided by the contacts that its busier end had in the last step.
#pragma once

#include "interactions/parting.h"
#include "interactions/sweep.h"

namespace motes::MOTES_ISA {

/// kRadii: particles have individual radii. kMasses: particles have individual masses.
template <bool kRadii, bool kMasses>
struct Collision {
  Floats reach2, reach, per_step, friction, restitution, slow, sleep2;

  /// Returns the change of the target's velocity by a pair at distance `d`, with unit vector `n` from target to source
  /// and `apart`, the source's velocity relative to the target.
  MOTES_INLINE Floats3 push(Floats reach_of_pair, Floats d, Floats3 n, Floats3 apart) const {
    const Floats along = dot(apart, n);
    Floats out = (reach_of_pair - d) * per_step;
    out = max(out, only(along < -slow, -(restitution * along)));
    const Floats3 slide = apart - n * along;
    const Floats speed = sqrt(dot(slide, slide));
    const Floats stop = min(speed, friction * out) / (speed + 1e-30f);
    return slide * stop - n * out;
  }

  struct Sums {
    Floats3 at, velocity, sum{};
    Floats part, own_radius, own_inverse, own_share{};
    float other_inverse = __builtin_nanf("");  // 1/kg, for which own_share was computed
    Ints touching{}, zeros{};

    MOTES_INLINE Sums(const Collision&, const Task& task, std::uint32_t i, std::uint32_t)
        : at(load_column(task.targets.column, interactions::at_x, i)),
          velocity(load_column(task.targets.column, interactions::velocity_x, i)),
          part(2.0f / max(load(task.targets.column[interactions::contacts] + i), all(2.0f))) {
      if (kRadii) own_radius = load(task.targets.column[interactions::radius] + i);
      if (kMasses) own_inverse = load(task.targets.column[interactions::inverse_mass] + i);
    }

    MOTES_INLINE void add(const Collision& law, const Task& task, std::uint32_t j) {
      const float* const* column = task.sources.column;
      const Floats3 r = seen_from(at, column, j);
      const Floats r2 = dot(r, r);
      const Floats reach = kRadii ? own_radius + column[interactions::radius][j] : law.reach;
      const Floats reach2 = kRadii ? reach * reach : law.reach2;
      const Mask near = r2 < reach2;
      if (!any(near)) return;
      zeros -= near & (r2 <= 0.0f);
      const Mask seen = near & (r2 > 0.0f);
      const Floats d = sqrt(r2);
      const Floats3 change =
          law.push(reach, d, r * (1.0f / d), velocity_seen_from(velocity, column, j)) * share(column, j);
      sum = sum + only(seen, change);
      touching -= seen;
    }

    /// Returns the target's part of a push: by mass, divided by half the contacts of the busier particle.
    MOTES_INLINE Floats share(const float* const* column, std::uint32_t j) {
      const float contacts = column[interactions::contacts][j];
      const Floats least = min(part, all(2.0f / (contacts > 2 ? contacts : 2.0f)));
      if (!kMasses) return least * 0.5f;
      const float inverse = column[interactions::inverse_mass][j];
      if (inverse != other_inverse) {  // divides once where all masses are equal
        other_inverse = inverse;
        own_share = own_inverse / max(own_inverse + inverse, all(1e-30f));
      }
      return least * own_share;
    }

    MOTES_INLINE void finish(const Collision& law, const Task& task, const Around& around, std::uint32_t i,
                             std::uint32_t last) {
      Ints self{};  // a particle with a radius finds itself at distance 0
      const Floats own_reach = kRadii ? own_radius + own_radius : law.reach;
      if (task.side == 0) self -= own_reach * own_reach > 0.0f;
      if (any(zeros > self)) part_equals(law, task, around, i, last);
      const Floats3 now = velocity + sum;
      const Floats count = to_floats(touching);
      const Mask sleeps = (touching > 1) & (dot(now, now) < law.sleep2);
      const Floats3 kept = only(~sleeps, now);
      store_lanes3(task.out, i, kept, last - i);
      store_lanes(task.out[3] + i, count, last - i);
      task.stats->pairs += sum_own(task.targets.cells, touching, i, last);
    }

    /// Adds the contacts with particles at the same position, after all others and in the same order.
    __attribute__((noinline)) void part_equals(const Collision& law, const Task& task, const Around& around,
                                               std::uint32_t i, std::uint32_t last) {
      const CellsView& targets = task.targets.cells;
      const CellsView& sources = task.sources.cells;
      for (std::uint32_t lane = 0; lane < last - i; ++lane) {
        const std::uint64_t own = id_of(task.targets, i + lane);
        Mask here{};
        here[lane] = -1;
        for (int n = 0; n < around.count; ++n) {
          const std::int32_t z = targets.z[i + lane];
          const std::uint32_t to = first_at(sources, *around.rows[n], z + 2);
          for (std::uint32_t j = first_at(sources, *around.rows[n], z - 1); j < to; ++j) {
            const std::uint64_t other = id_of(task.sources, j);
            const Floats3 r = seen_from(at, task.sources.column, j);
            const Floats r2 = dot(r, r);
            if (r2[lane] > 0 || (task.side == 0 && own == other)) continue;
            const float* const* column = task.sources.column;
            const Floats reach = kRadii ? own_radius + column[interactions::radius][j] : law.reach;
            if (!(r2[lane] < reach[lane] * reach[lane])) continue;
            const Floats3 change = law.push(reach, Floats{}, all3(parting(own, other, task.side)),
                                            velocity_seen_from(velocity, column, j));
            sum = sum + only(here, change * share(column, j));
            touching -= here;
          }
        }
      }
    }
  };
};

/// The acceleration, m/s2, from which the speeds of slow and sleeping particles are derived.
inline constexpr double kGravity = 9.81;

template <bool kRadii, bool kMasses>
void collide_as(const Task& task) {
  const auto n = numbers_of<numbers::collide, double>(task);
  const double sleep = n.sleep < 0 ? 2.5 * kGravity * static_cast<double>(task.dt) : n.sleep;
  const auto restitution = static_cast<float>(n.restitution);
  // Particles that approach each other more slowly do not rebound.
  const float slow =
      restitution > 0 ? static_cast<float>(2 * kGravity * static_cast<double>(task.dt)) : __builtin_inff();
  sweep(task, Collision<kRadii, kMasses>{all(task.reach * task.reach), all(task.reach), all(1.0f / task.dt),
                                         all(static_cast<float>(n.friction)), all(1.0f + restitution), all(slow),
                                         all(static_cast<float>(sleep * sleep))});
}

inline void collide(const Task& task) {
  constexpr decltype(&collide_as<false, false>) kKernels[2][2] = {{collide_as<false, false>, collide_as<false, true>},
                                                                  {collide_as<true, false>, collide_as<true, true>}};
  kKernels[task.radii ? 1 : 0][task.masses ? 1 : 0](task);
}

namespace laws {
inline constexpr interactions::Law collide = {
    .act = MOTES_ISA::collide,
    .radius =
        [](const double* recorded, bool second) {
          const auto n = actions::read_numbers<numbers::collide>(recorded);
          return second ? n.other_radius : n.radius;
        },
    .clear = [](const double* recorded) { return actions::read_numbers<numbers::collide>(recorded).clear; },
    .looks_ahead = true,
    .inverse_masses = true,
    .uniform = true,
    .between_systems = true,
};
}  // namespace laws

}  // namespace motes::MOTES_ISA
