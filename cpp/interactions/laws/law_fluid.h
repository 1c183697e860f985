// fluid: particles of a liquid keep their density (Macklin and Mueller 2013, "Position based fluids", one iteration, as
// an action on velocities). At predicted positions, all particles first find the pressure that keeps them at rest
// density; then each sums its own pushes and those of its neighbours. Excess density that exists already is relieved
// slowly (Baumgarte 1972); relieved at once, it would make the liquid fly apart and never come to rest. Kernels of
// density and gradient are those of Mueller et al. (2003).
#pragma once

#include "interactions/parting.h"
#include "interactions/sweep.h"

namespace motes::MOTES_ISA {

/// Smoothing kernels with support `radius`, in units of `unit`, a power of two near it: powers of the radius itself may
/// be beyond float32, and to scale by powers of two changes no bits.
struct SmoothingKernel {
  float unit;  // m
  Floats per_radius;  // 1/m
  Floats high, steep;

  explicit SmoothingKernel(float given) : unit(power_of_two(given)), per_radius(all(1 / given)) {
    const float radius = given / unit;
    high = all(1.5666815f / (radius * radius * radius));
    steep = all(14.323945f / (radius * radius * radius * radius));
  }

  /// Returns a squared distance, m2, in squared radii.
  MOTES_INLINE Floats in_radii(Floats r2) const { return r2 * (per_radius * per_radius); }

  /// Returns the density kernel at squared distance q2 (in radii), 1/unit3.
  MOTES_INLINE Floats share(Floats q2) const {
    const Floats left = 1.0f - q2;
    return high * left * left * left;
  }
  /// Returns the magnitude of the gradient kernel at distance q (in radii), 1/unit4.
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
    q2 = spread.in_radii(r2);
    seen = q2 < 1.0f;
    other = seen & (Mask)(lane_numbers() + first != all_uints(j));
    const Floats d = sqrt(r2);
    q = d * spread.per_radius;
    normal = r * (1.0f / d);
    const Mask here = other & (r2 <= 0.0f);
    if (any(here)) part(task, here, first, j);
  }

  static MOTES_INLINE unsigned sees(const Task& task, const Floats3& at, const SmoothingKernel& spread,
                                    std::uint32_t j) {
    const Floats3 r = seen_from(at, task.sources.column, j);
    return bits_below(spread.in_radii(dot(r, r)), all(1.0f));
  }

  // Gives sources at the same position a direction from their ids.
  __attribute__((noinline)) void part(const Task& task, Mask here, std::uint32_t first, std::uint32_t j) {
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      if (here[lane] == 0 || first + lane >= count_of(task.targets)) continue;
      set_lane(normal, lane, parting(id_of(task.targets, first + lane), id_of(task.sources, j), 0));
    }
  }
};

/// The unit of mass, kg, a power of two near rest_density unit^3, and the inverse rest density in these units.
struct Heaviness {
  float mass, per_mass, per_density;

  Heaviness(float rest_density, float unit) : mass(power_of_two(rest_density) * unit * unit * unit) {
    per_mass = 1 / mass;
    per_density =
        static_cast<float>(double{1 / rest_density} * double{mass} / (double{unit} * double{unit} * double{unit}));
  }
};

/// Computes the pressure of each particle: the multiplier of its density constraint, in units of mass unit^2.
struct Pressure {
  SmoothingKernel spread;
  Heaviness heavy;
  Floats step;

  static constexpr float kRelieved = 0.05f;  // part of existing excess density that is relieved per step

  struct Sums {
    std::uint32_t first;
    Floats3 at, velocity, slope{};
    Floats mass, density{}, slopes2{};
    Floats parts{};  // rate at which the density falls, kg m/(unit4 s)

    MOTES_INLINE Sums(const Pressure&, const Task& task, std::uint32_t i, std::uint32_t)
        : first(i), at(load_column(task.targets.column, interactions::at_x, i)),
          velocity(load_column(task.targets.column, interactions::velocity_x, i)),
          mass(load(task.targets.column[interactions::mass] + i)) {}

    MOTES_INLINE unsigned sees(const Pressure& law, const Task& task, std::uint32_t j) const {
      return Neighbour::sees(task, at, law.spread, j);
    }

    MOTES_INLINE void add(const Pressure& law, const Task& task, std::uint32_t j, unsigned) {
      const Neighbour n(task, at, law.spread, first, j);
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
      const float per_density = law.heavy.per_density, per_mass = law.heavy.per_mass;
      // Nothing can relieve what a particle that is denser than the liquid by itself has alone.
      const Floats alone = law.spread.high * mass * per_mass * per_density;
      const Floats then = density * per_mass * per_density - max(alone, all(1.0f));
      const Floats now = then + parts * per_mass * (1 / law.spread.unit) * per_density * law.step;
      const Floats above = max(then - (1.0f - kRelieved) * max(now, Floats{}), Floats{});
      const Floats3 s = slope * per_mass;
      const Floats gives =
          (dot(s, s) / max(mass * per_mass, all(1e-30f)) + slopes2 * per_mass) * (per_density * per_density);
      store_lanes(task.out[0] + i, above / max(gives, all(1e-30f)), last - i);
    }
  };
};

/// Computes the new velocity of each particle.
struct Fluid {
  SmoothingKernel spread;
  Heaviness heavy;
  Floats step, viscosity10, cohesion;  // of a unit of mass
  Floats per_radius;  // 1/unit
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

    MOTES_INLINE unsigned sees(const Fluid& law, const Task& task, std::uint32_t j) const {
      return Neighbour::sees(task, at, law.spread, j);
    }

    MOTES_INLINE void add(const Fluid& law, const Task& task, std::uint32_t j, unsigned) {
      const Neighbour n(task, at, law.spread, first, j);
      const float* const* column = task.sources.column;
      const float of = column[interactions::mass][j];
      const Floats steep = law.spread.slope(n.q);
      if (of != other_mass) {  // divides once where all masses are equal
        other_mass = of;
        own_part = pressure * (of / max(mass, all(__FLT_MIN__)));
      }
      const Floats both = own_part + column[interactions::pressure][j];
      push = push - only(n.other, n.normal * (steep * both));
      const Floats rubs = law.viscosity10 * dot(velocity_seen_from(velocity, column, j), n.normal) * steep *
                          law.per_radius / (n.q + 0.1f);
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
      const Floats3 by_push = push * (law.heavy.per_density / law.step * law.spread.unit);
      const Floats3 by_drag = drag * (law.heavy.per_density * law.step);
      const Floats3 now = velocity + only(mass > 0.0f, by_push + by_drag);
      store_lanes3(task.out, i, now, last - i);
      task.stats->pairs += sum_own(task.targets.cells, pairs, i, last);
    }
  };
};

inline void find_pressure(const Task& task) {
  const SmoothingKernel spread(task.reach);
  sweep(task, Pressure{spread, Heaviness(numbers_of<numbers::fluid>(task).rest_density, spread.unit), all(task.dt)});
}

inline void fluid(const Task& task) {
  const auto n = numbers_of<numbers::fluid>(task);
  // A basic viscosity lets a liquid come to rest; above h^2 / (24 dt), a step would overshoot and velocities would
  // oscillate.
  const float all_at_once = task.reach * task.reach / task.dt;
  const float viscosity10 = 10 * __builtin_fminf(n.viscosity + all_at_once / 4000, all_at_once / 24);
  const SmoothingKernel spread(task.reach);
  const Heaviness heavy(n.rest_density, spread.unit);
  const float unit = spread.unit;
  sweep(task, Fluid{spread, heavy, all(task.dt), all(viscosity10 / unit / unit * heavy.per_mass),
                    all(n.cohesion * heavy.per_mass), spread.per_radius * unit, n.cohesion != 0});
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
