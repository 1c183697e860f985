// fluid: particles of a liquid keep their density (Macklin and Mueller 2013, "Position based fluids", one iteration, as
// an action on velocities). At predicted positions, all particles first find the pressure that keeps them at rest
// density; then each sums its own pushes and those of its neighbours. Excess density that exists already is relieved
// slowly (Baumgarte 1972); relieved at once, it would make the liquid fly apart and never come to rest. Kernels of
// density and gradient are those of Mueller et al. (2003).
#pragma once

#include "interactions/parting.h"
#include "interactions/sweep.h"

namespace motes::MOTES_ISA {

/// Smoothing kernels with support `radius`.
struct SmoothingKernel {
  Floats per_radius;  // 1/m
  Floats high, steep;

  explicit SmoothingKernel(float radius)
      : per_radius(all(1 / radius)), high(all(1.5666815f / (radius * radius * radius))),
        steep(all(14.323945f / (radius * radius * radius * radius))) {}

  /// Returns the density kernel at squared distance q2 (in radii), 1/m3.
  MOTES_INLINE Floats share(Floats q2) const {
    const Floats left = 1.0f - q2;
    return high * left * left * left;
  }
  /// Returns the magnitude of the gradient kernel at distance q (in radii), 1/m4.
  MOTES_INLINE Floats slope(Floats q) const {
    const Floats left = 1.0f - q;
    return steep * left * left;
  }
};

/// A source relative to the targets: distance, direction, and which targets are within reach.
struct Neighbour {
  Floats q2, q;  // distance in radii
  Floats3 normal;
  Mask seen, other;  // within the radius; the same without the target itself

  MOTES_INLINE Neighbour(const Task& task, const Floats3& at, const SmoothingKernel& spread, std::uint32_t first,
                         std::uint32_t j) {
    const Floats3 r = seen_from(at, task.sources.column, j);
    const Floats r2 = dot(r, r);
    q2 = r2 * (spread.per_radius * spread.per_radius);
    seen = q2 < 1.0f;
    other = seen & (Mask)(lane_numbers() + first != all_uints(j));
    if (!any(seen)) return;
    const Floats d = sqrt(r2);
    q = d * spread.per_radius;
    normal = r * (1.0f / d);
    const Mask here = other & (r2 <= 0.0f);
    if (any(here)) part(task, here, first, j);
  }

  // Gives sources at the same position a direction from their ids.
  __attribute__((noinline)) void part(const Task& task, Mask here, std::uint32_t first, std::uint32_t j) {
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      if (here[lane] == 0 || first + lane >= count_of(task.targets)) continue;
      set_lane(normal, lane, parting(id_of(task.targets, first + lane), id_of(task.sources, j), 0));
    }
  }
};

/// Computes the pressure of each particle: the multiplier of its density constraint.
struct Pressure {
  SmoothingKernel spread;
  Floats step, per_density;

  static constexpr float kRelieved = 0.05f;  // part of existing excess density that is relieved per step

  struct Sums {
    std::uint32_t first;
    Floats3 at, velocity, slope{};
    Floats mass, density{}, slopes2{};
    Floats parts{};  // rate at which the density falls, kg/(m3 s)

    MOTES_INLINE Sums(const Pressure&, const Task& task, std::uint32_t i, std::uint32_t)
        : first(i), at(load_column(task.targets.column, interactions::at_x, i)),
          velocity(load_column(task.targets.column, interactions::velocity_x, i)),
          mass(load(task.targets.column[interactions::mass] + i)) {}

    MOTES_INLINE void add(const Pressure& law, const Task& task, std::uint32_t j) {
      const Neighbour n(task, at, law.spread, first, j);
      if (!any(n.seen)) return;
      const float of = task.sources.column[interactions::mass][j];
      density = density + only(n.seen, law.spread.share(n.q2) * of);
      const Floats steep = law.spread.slope(n.q);
      slope = slope + only(n.other, n.normal * (steep * of));
      slopes2 = slopes2 + only(n.other, steep * steep * of);
      const float* const* column = task.sources.column;
      parts = parts + only(n.other, dot(velocity_seen_from(velocity, column, j), n.normal) * steep * of);
    }

    MOTES_INLINE void finish(const Pressure& law, const Task& task, const Around&, std::uint32_t i,
                             std::uint32_t last) const {
      const Floats then = density * law.per_density - 1.0f;
      const Floats now = then + parts * law.per_density * law.step;
      const Floats above = max(then - (1.0f - kRelieved) * max(now, Floats{}), Floats{});
      const Floats gives = (dot(slope, slope) / max(mass, all(1e-30f)) + slopes2) * (law.per_density * law.per_density);
      store_lanes(task.out[0] + i, above / max(gives, all(1e-30f)), last - i);
    }
  };
};

/// Computes the new velocity of each particle.
struct Fluid {
  SmoothingKernel spread;
  Floats step, per_density, viscosity10, cohesion;
  bool coheres;

  struct Sums {
    std::uint32_t first;
    Floats3 at, velocity, push{}, drag{};
    Floats mass, pressure, own_part{};
    float other_mass = __builtin_nanf("");  // kg, for which own_part was computed
    Ints pairs{};

    MOTES_INLINE Sums(const Fluid&, const Task& task, std::uint32_t i, std::uint32_t)
        : first(i), at(load_column(task.targets.column, interactions::at_x, i)),
          velocity(load_column(task.targets.column, interactions::velocity_x, i)),
          mass(load(task.targets.column[interactions::mass] + i)),
          pressure(load(task.targets.column[interactions::pressure] + i)) {}

    MOTES_INLINE void add(const Fluid& law, const Task& task, std::uint32_t j) {
      const Neighbour n(task, at, law.spread, first, j);
      if (!any(n.other)) return;
      const float* const* column = task.sources.column;
      const float of = column[interactions::mass][j];
      const Floats steep = law.spread.slope(n.q);
      if (of != other_mass) {  // divides once where all masses are equal
        other_mass = of;
        own_part = pressure * (of / max(mass, all(1e-30f)));
      }
      const Floats both = own_part + column[interactions::pressure][j];
      push = push - only(n.other, n.normal * (steep * both));
      const Floats rubs = law.viscosity10 * dot(velocity_seen_from(velocity, column, j), n.normal) * steep *
                          law.spread.per_radius / (n.q + 0.1f);
      const Floats drawn = law.coheres ? rubs + law.cohesion * pull(law, n.q) : rubs;
      drag = drag + only(n.other, n.normal * (drawn * of));
      pairs -= n.other;
    }

    /// Returns the cohesion kernel: attraction beyond half the radius, repulsion below (Akinci et al. 2013, "Versatile
    /// surface tension and adhesion for SPH fluids").
    static MOTES_INLINE Floats pull(const Fluid& law, Floats q) {
      const Floats left = 1.0f - q;
      const Floats bump = left * left * left * (q * q * q);
      return law.spread.high * 6.5015f * select(q > 0.5f, bump, 2.0f * bump - 1.0f / 64);
    }

    MOTES_INLINE void finish(const Fluid& law, const Task& task, const Around&, std::uint32_t i,
                             std::uint32_t last) const {
      const Floats3 by_push = push * (law.per_density / law.step);
      const Floats3 by_drag = drag * (law.per_density * law.step);
      const Floats3 now = velocity + only(mass > 0.0f, by_push + by_drag);
      store_lanes3(task.out, i, now, last - i);
      task.stats->pairs += sum_own(task.targets.cells, pairs, i, last);
    }
  };
};

inline void find_pressure(const Task& task) {
  const float rest_density = numbers_of<numbers::fluid>(task).rest_density;
  sweep(task, Pressure{SmoothingKernel(task.reach), all(task.dt), all(1 / rest_density)});
}

inline void fluid(const Task& task) {
  const auto n = numbers_of<numbers::fluid>(task);
  // A basic viscosity lets a liquid come to rest; above h^2 / (24 dt), a step would overshoot and velocities would
  // oscillate.
  const float all_at_once = task.reach * task.reach / task.dt;
  const float viscosity10 = 10 * __builtin_fminf(n.viscosity + all_at_once / 4000, all_at_once / 24);
  sweep(task, Fluid{SmoothingKernel(task.reach), all(task.dt), all(1 / n.rest_density), all(viscosity10),
                    all(n.cohesion), n.cohesion != 0});
}

namespace laws {
inline constexpr interactions::Law fluid = {
    .act = MOTES_ISA::fluid,
    .prepare = find_pressure,
    .reach = [](const double* recorded) { return actions::read_numbers<numbers::fluid>(recorded).radius; },
    .looks_ahead = true,
};
}  // namespace laws

}  // namespace motes::MOTES_ISA
