// collide: spheres push each other apart so that they do not overlap at the end of the step, with Coulomb friction
// (position-based dynamics with one iteration, as an action on velocities: Mueller et al. 2007, "Position based
// dynamics"). Each pair is computed at both ends with opposite signs, so momentum is conserved. Piles are stiff but
// stable because each push is divided by the contacts that its busier end had in the last step.
//
// The push acts along the line of centres at the end of the step. A fast pair may have changed sides by then, or turned
// so far that this push would give it energy: it is pushed along the line of centres at which it touched first.
#pragma once

#include "interactions/parting.h"
#include "interactions/quads3.h"
#include "interactions/sweep.h"
#include "simd/squeeze.h"

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

  /// Pairs within reach, in the order in which they are found. Of a vector of targets, a source is usually within reach
  /// of one or two: pairs of several sources fill a vector, and each target's changes are added in their order.
  struct Queue {
    static constexpr std::uint32_t kMost = 112;  // pairs, and up to a vector more
    static constexpr int kContacts = 6, kRadius = 7, kInverse = kRadius + kRadii, kColumns = kInverse + kMasses;

    alignas(64) std::uint32_t lane[kMost + 2 * kLanes];  // of the target
    alignas(64) float source[kColumns][kMost + 2 * kLanes];  // its columns
    alignas(64) Four sums[kLanes] = {};  // by target: change of velocity, and number of contacts
    std::uint32_t count = 0;

    MOTES_INLINE void push(unsigned chosen, const float* const* column, std::uint32_t j) {
      using interactions::at_x, interactions::velocity_x;
      const Selected selected(chosen);
      store_selected(lane + count, selected, lane_numbers());
      const auto put = [&](int c, int from) { store(source[c] + count, all(column[from][j])); };
      for (int c = 0; c < 3; ++c) put(c, at_x + c);
      for (int c = 0; c < 3; ++c) put(3 + c, velocity_x + c);
      put(kContacts, interactions::contacts);
      if (kRadii) put(kRadius, interactions::radius);
      if (kMasses) put(kInverse, interactions::inverse_mass);
      count += static_cast<std::uint32_t>(selected.number());
    }
  };

  struct Sums {
    Floats3 at, velocity;
    Floats part, own_radius, own_inverse;
    std::uint32_t self;  // number of the first target among the sources
    bool equals = false;  // whether another particle is at a target's position
    Queue queue;

    MOTES_INLINE Sums(const Collision&, const Task& task, std::uint32_t i, std::uint32_t)
        : at(load_column(task.targets.column, interactions::at_x, i)),
          velocity(load_column(task.targets.column, interactions::velocity_x, i)),
          part(2.0f / max(load(task.targets.column[interactions::contacts] + i), all(2.0f))),
          self(task.side == 0 ? i : UINT32_MAX - kLanes) {
      if (kRadii) own_radius = load(task.targets.column[interactions::radius] + i);
      if (kMasses) own_inverse = load(task.targets.column[interactions::inverse_mass] + i);
    }

    MOTES_INLINE Floats reach_to(const Collision& law, const float* const* column, std::uint32_t j) const {
      return kRadii ? own_radius + column[interactions::radius][j] : law.reach;
    }
    static MOTES_INLINE Floats squared(const Collision& law, Floats reach) {
      return kRadii ? reach * reach : law.reach2;
    }

    MOTES_INLINE unsigned sees(const Collision& law, const Task& task, std::uint32_t j) const {
      const Floats3 r = seen_from(at, task.sources.column, j);
      return bits_below(dot(r, r), squared(law, reach_to(law, task.sources.column, j)));
    }

    MOTES_INLINE void add(const Collision& law, const Task& task, std::uint32_t j, unsigned seen) {
      const std::uint32_t own = j - self;  // its lane, if it is a target
      queue.push(own < kLanes ? seen & ~(1u << own) : seen, task.sources.column, j);
      if (queue.count > Queue::kMost) add_queued(law);
    }

    /// Adds the pairs of the queue, a vector at a time, and empties it.
    __attribute__((noinline)) void add_queued(const Collision& law) {
      for (std::uint32_t p = 0; p < queue.count; p += kLanes) {
        const Mask used = first_lanes(queue.count - p);
        const Ints lane = (Ints)load_uints(queue.lane + p) & used;
        const auto own = [&](const Floats3& v) { return Floats3{pick(v.x, lane), pick(v.y, lane), pick(v.z, lane)}; };
        const auto other = [&](int c) { return load(queue.source[c] + p); };
        const Floats3 v = own(velocity), its_v{other(3), other(4), other(5)};
        Floats3 r = Floats3{other(0), other(1), other(2)} - own(at);
        if (law.fast) r = r + (law.cut_off(its_v) - law.cut_off(v));
        const Floats r2 = dot(r, r), reach = kRadii ? pick(own_radius, lane) + other(Queue::kRadius) : law.reach;
        const Mask near = used & (r2 < squared(law, reach)), seen = near & (r2 > 0.0f);
        equals |= any(near & (r2 <= 0.0f));
        const Floats d = sqrt(r2);
        const Floats shared = share(pick(part, lane), other(Queue::kContacts), kMasses ? pick(own_inverse, lane) : part,
                                    kMasses ? other(Queue::kInverse) : part);
        const Floats3 change = law.push({reach, r * (1.0f / d), d, its_v - v}, seen) * shared;
        const Quads changes = quads_of(only(seen, change), only(seen, all(1.0f)));
        for (std::uint32_t k = 0; k < kLanes && p + k < queue.count; ++k) {
          queue.sums[queue.lane[p + k]] += load_four(reinterpret_cast<const float*>(changes.word[k]));
        }
      }
      queue.count = 0;
    }

    /// Returns the target's part of a push: by mass, divided by half the contacts of the busier particle. `part`: what
    /// the target's own contacts allow.
    static MOTES_INLINE Floats share(Floats part, Floats contacts, Floats own_inverse, Floats inverse) {
      const Floats least = min(part, 2.0f / select(contacts > 2.0f, contacts, all(2.0f)));
      return kMasses ? least * (own_inverse / max(own_inverse + inverse, all(1e-30f))) : least * 0.5f;
    }

    MOTES_INLINE void finish(const Collision& law, const Task& task, const Around& around, std::uint32_t i,
                             std::uint32_t last) {
      add_queued(law);
      const FourWords sums = load_fours([&](std::size_t lane) { return &queue.sums[lane]; });
      Floats3 sum = three(sums);
      Ints touching = to_ints(fourth(sums));
      if (equals) part_equals(law, task, around, i, last, sum, touching);
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
                                               std::uint32_t i, std::uint32_t last, Floats3& sum,
                                               Ints& touching) const {
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
            const float* const* column = task.sources.column;
            const auto all_at = [&](int c) { return all(column[c][j]); };
            Floats3 r = seen_from(at, column, j);
            const Floats before2 = dot(r, r);
            const Floats3 its_v{all_at(interactions::velocity_x), all_at(interactions::velocity_y),
                                all_at(interactions::velocity_z)};
            if (law.fast) r = r + (law.cut_off(its_v) - law.cut_off(velocity));
            const Floats r2 = dot(r, r);
            if (r2[lane] > 0 || (task.side == 0 && own == other)) continue;
            const Floats reach = reach_to(law, column, j);
            if (!(max(before2, r2)[lane] < reach[lane] * reach[lane])) continue;
            const Floats shared = share(part, all_at(interactions::contacts), kMasses ? own_inverse : part,
                                        kMasses ? all_at(interactions::inverse_mass) : part);
            const Floats3 change =
                law.push({reach, all3(parting(own, other, task.side)), Floats{}, its_v - velocity}, here) * shared;
            sum = sum + only(here, change);
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
