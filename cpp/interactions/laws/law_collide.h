// collide: spheres push each other apart so that they do not overlap at the end of the step, with Coulomb friction
// (position-based dynamics with one iteration, as an action on velocities: Mueller et al. 2007, "Position based
// dynamics"). Each pair is computed at both ends with opposite signs, so momentum is conserved. Piles are stiff but
// stable because each push is divided by the contacts that its busier end had in the last step.
//
// The push acts along the line of centres at the end of the step. A fast pair may have changed sides by then, or turned
// so far that this push would give it energy: it is pushed along the line of centres at which it touched first.
#pragma once

#include "interactions/parting.h"
#include "interactions/sweep.h"

namespace motes::MOTES_ISA {

/// kRadii: particles have individual radii. kMasses: particles have individual masses.
template <bool kRadii, bool kMasses>
struct Collision {
  Floats reach2, reach, step, half_step, per_step, friction, restitution, slow, sleep2;
  bool fast;  // whether predicted displacements may have been cut off

  /// A pair relative to its target: direction to the source and distance at the end of the step, and velocity.
  struct Pair {
    Floats reach;
    Floats3 n;
    Floats d;
    Floats3 apart;
  };

  /// Returns the change of the target's velocity.
  MOTES_INLINE Floats3 push(Pair pair, const Mask& seen) const {
    const Push push = push_along(pair, pair.reach - pair.d);
    // touch_first() takes longer than a push, and few pairs need it: those that part faster than what overlapped at the
    // start of the step explains. Here they are told apart without its root, |start|^2 from its parts along n and
    // across it, and with a margin for rounding.
    const Floats before = pair.d - push.along * step, aside = push.speed * step;
    const Floats parted = pair.reach * 0.999f - (push.along + push.out) * half_step;
    const Mask may_gain =
        seen & (push.along + push.along + push.out > 0.0f) & (before * before + aside * aside > parted * abs(parted));
    if (any(may_gain)) {
      const Pair copy = pair;  // for the call alone, so that the pair itself stays in registers
      return touch_first(copy, may_gain);
    }
    return change_by(pair.n, push);
  }

  /// Returns the part of a displacement that the predicted position lacks: see interactions::step_limit.
  MOTES_INLINE Floats3 cut_off(Floats3 v) const {
    const Floats3 way = v * step;
    const Floats length2 = dot(way, way);
    return only(length2 > reach2, way - way * (reach / sqrt(length2)));
  }

  /// Returns whether a source's predicted position lacks a part of its displacement.
  MOTES_INLINE bool cuts_off(const float* const* column, std::uint32_t j) const {
    const float x = column[interactions::velocity_x][j] * step[0];
    const float y = column[interactions::velocity_y][j] * step[0];
    const float z = column[interactions::velocity_z][j] * step[0];
    return x * x + y * y + z * z > reach2[0];
  }

  /// Speeds of a pair, m/s: its velocity apart along n and across it, and what a push adds and stops of these.
  struct Push {
    Floats along, out;
    Floats3 slide;
    Floats speed, stopped;

    /// Returns the fall of the square of the speed across n.
    MOTES_INLINE Floats lost() const { return stopped * (speed + speed - stopped); }
  };

  MOTES_INLINE Push push_along(const Pair& pair, Floats overlap) const {
    Push push;
    push.along = dot(pair.apart, pair.n);
    push.out = max(overlap * per_step, only(push.along < -slow, -(restitution * push.along)));
    push.slide = pair.apart - pair.n * push.along;
    push.speed = sqrt(dot(push.slide, push.slide));
    push.stopped = min(push.speed, friction * push.out);
    return push;
  }

  static MOTES_INLINE Floats3 change_by(Floats3 n, const Push& push) {
    return push.slide * (push.stopped / (push.speed + 1e-30f)) - n * push.out;
  }

  /// Returns the change of the target's velocity where some pairs would gain energy (the lanes of `among`): they are
  /// pushed as at their first touch, unless the energy only parts what overlapped at the start of the step. Pairs that
  /// miss each other are not pushed.
  __attribute__((noinline)) Floats3 touch_first(const Pair& given, const Mask& among) const {
    Pair pair = given;
    Push push = push_along(pair, pair.reach - pair.d);
    Mask gains = among & (push.out * (push.along + push.along + push.out) > push.lost());
    const Floats3 way = pair.apart * step, start = pair.n * pair.d - way;
    const Floats d2 = dot(start, start);
    const Floats overlapped = max(pair.reach - sqrt(d2), Floats{}) * per_step;
    gains &= (push.along + push.out > overlapped + overlapped) & (d2 > 0.0f);
    if (!any(gains)) return change_by(pair.n, push);
    // |start + part way| = reach, in units of the reach
    const Floats per_reach = 1.0f / pair.reach;
    const Floats3 s = start * per_reach, w = way * per_reach;
    const Floats a = dot(w, w), b = dot(s, w), c = max(dot(s, s) - 1.0f, Floats{});
    const Floats discriminant = b * b - a * c;
    const Floats part = select(c > 0.0f, c / (sqrt(max(discriminant, Floats{})) - b), Floats{});
    const Mask touches = (c <= 0.0f) | ((b < 0.0f) & (discriminant >= 0.0f) & (part <= 1.0f));
    const Floats3 there = s + w * part;
    pair.n = select(gains, there * (1.0f / sqrt(dot(there, there))), pair.n);
    const Push first = push_along(pair, max(pair.reach - dot(pair.n, start + way), Floats{}));
    push.out = select(gains, only(touches, first.out), push.out);
    push.slide = select(gains, first.slide, push.slide);
    push.speed = select(gains, first.speed, push.speed);
    push.stopped = select(gains, only(touches, first.stopped), push.stopped);
    return change_by(pair.n, push);
  }

  struct Sums {
    Floats3 at, velocity, sum{};
    Floats3 lacks{};  // law.cut_off(velocity)
    bool lack = false;  // whether any of these is not zero
    Floats part, own_radius, own_inverse, own_share{};
    float other_inverse = __builtin_nanf("");  // 1/kg, for which own_share was computed
    Ints touching{}, zeros{};

    MOTES_INLINE Sums(const Collision& law, const Task& task, std::uint32_t i, std::uint32_t)
        : at(load_column(task.targets.column, interactions::at_x, i)),
          velocity(load_column(task.targets.column, interactions::velocity_x, i)),
          part(2.0f / max(load(task.targets.column[interactions::contacts] + i), all(2.0f))) {
      if (law.fast) {
        lacks = law.cut_off(velocity);
        lack = any((lacks.x != 0.0f) | (lacks.y != 0.0f) | (lacks.z != 0.0f));
      }
      if (kRadii) own_radius = load(task.targets.column[interactions::radius] + i);
      if (kMasses) own_inverse = load(task.targets.column[interactions::inverse_mass] + i);
    }

    MOTES_INLINE Floats reach_to(const Collision& law, const float* const* column, std::uint32_t j) const {
      return kRadii ? own_radius + column[interactions::radius][j] : law.reach;
    }
    static MOTES_INLINE Floats squared(const Collision& law, Floats reach) {
      return kRadii ? reach * reach : law.reach2;
    }

    MOTES_INLINE bool sees(const Collision& law, const Task& task, std::uint32_t j) const {
      const Floats3 r = seen_from(at, task.sources.column, j);
      return any(dot(r, r) < squared(law, reach_to(law, task.sources.column, j)));
    }

    MOTES_INLINE void add(const Collision& law, const Task& task, std::uint32_t j) {
      const float* const* column = task.sources.column;
      Floats3 r = seen_from(at, column, j);
      Floats r2 = dot(r, r);
      const Floats reach = reach_to(law, column, j), reach2 = squared(law, reach);
      Mask near = r2 < reach2;
      if (law.fast && (lack || law.cuts_off(column, j))) {
        r = later(law, r, column, j);
        r2 = dot(r, r);
        near &= r2 < reach2;
      }
      zeros -= near & (r2 <= 0.0f);
      const Mask seen = near & (r2 > 0.0f);
      const Floats d = sqrt(r2);
      const Floats3 change =
          law.push({reach, r * (1.0f / d), d, velocity_seen_from(velocity, column, j)}, seen) * share(column, j);
      sum = sum + only(seen, change);
      touching -= seen;
    }

    /// Returns where a source is, relative to the targets, at the end of the step; `r`: by the predicted positions.
    MOTES_INLINE Floats3 later(const Collision& law, Floats3 r, const float* const* column, std::uint32_t j) const {
      const Floats3 of_source = {all(column[interactions::velocity_x][j]), all(column[interactions::velocity_y][j]),
                                 all(column[interactions::velocity_z][j])};
      return r + (law.cut_off(of_source) - lacks);
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
      if (any(zeros > self)) {
        Sums copy = *this;  // the address of a copy: the loop over sources keeps the sums in registers
        copy.part_equals(law, task, around, i, last);
        *this = copy;
      }
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
            Floats3 r = seen_from(at, task.sources.column, j);
            const Floats before2 = dot(r, r);
            if (law.fast) r = later(law, r, task.sources.column, j);
            const Floats r2 = dot(r, r);
            if (r2[lane] > 0 || (task.side == 0 && own == other)) continue;
            const float* const* column = task.sources.column;
            const Floats reach = reach_to(law, column, j);
            if (!(max(before2, r2)[lane] < reach[lane] * reach[lane])) continue;
            const Floats3 change = law.push(
                {reach, all3(parting(own, other, task.side)), Floats{}, velocity_seen_from(velocity, column, j)}, here);
            sum = sum + only(here, change * share(column, j));
            touching -= here;
          }
        }
      }
    }
  };
};

template <bool kRadii, bool kMasses>
void collide_as(const Task& task) {
  const auto n = numbers_of<numbers::collide, double>(task);
  const double sleep = n.sleep < 0 ? 2.5 * task.gravity * static_cast<double>(task.dt) : n.sleep;
  const auto restitution = static_cast<float>(n.restitution);
  // Particles that approach each other more slowly do not rebound: gravity alone lets those at rest approach.
  const float slow = restitution > 0 ? static_cast<float>(0.8 * sleep) : __builtin_inff();
  sweep(task,
        Collision<kRadii, kMasses>{all(task.reach * task.reach), all(task.reach), all(task.dt), all(task.dt * 0.5f),
                                   all(1.0f / task.dt), all(static_cast<float>(n.friction)), all(1.0f + restitution),
                                   all(slow), all(static_cast<float>(sleep * sleep)), task.fast});
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
