// contact: discrete elements (Cundall and Strack 1979). Touching spheres push each other apart by damped springs; their
// surfaces hold each other by springs that remember how far they have slid and rolled, up to Coulomb's limit (Luding
// 2008, "Cohesive, frictional powders"). Each touch is computed at both ends with opposite signs, so momentum and
// angular momentum are conserved.
#pragma once

#include "interactions/parting.h"
#include "interactions/sweep.h"
#include "particles/touches.h"
#include "simd/elementary.h"

namespace motes::MOTES_ISA {

/// Radius and inverse mass of a particle.
struct Inertia {
  Floats radius, inverse;  // m, 1/kg

  /// Returns the inverse moment of inertia of a solid sphere, 1/(kg m2).
  MOTES_INLINE Floats inverse_moment() const { return 2.5f * inverse / max(radius * radius, all(1e-30f)); }
};

/// Geometry and motion of a touch, seen from the target.
struct Touching {
  Floats3 normal;  // towards the source
  Floats overlap;
  Floats3 apart;  // velocity of the source relative to the target
  Floats3 spin, other_spin;
  Inertia own, other;
};

/// Force and torque of a touch on the target, N and N m.
struct Push {
  Floats3 force, torque;
  Mask softened;  // the spring had to be softened
};

/// A damped spring: N/m, and N s/m.
struct Spring {
  Floats stiffness, damper;
};

struct Contact {
  Floats step, stiffness, damping, friction, rolling_friction;

  // Limits stiffness so that a touch, pi sqrt(m / stiffness) long with m half the harmonic mean of the masses, lasts at
  // least five steps; then even twelve touches at once are stable.
  static constexpr float kMostStiff = 0.39f;

  // Stiffness of springs along the surface relative to that between the centres: with 2/7, spheres that hit each other
  // slide and slip back in one period (Schaefer et al. 1996, "Force schemes in simulations of granular materials").
  static constexpr float kAlong = 2.0f / 7;
  static constexpr float kAlongDamping = 0.5f;

  /// Stretches a spring by a step at `speed` and returns its pull, at most `limit`; `at`: its elongation, which is cut
  /// when it slips.
  MOTES_INLINE Floats3 held(Spring spring, Floats3& at, Floats3 speed, Floats limit) const {
    at = at + speed * step;
    Floats3 pull = at * spring.stiffness + speed * spring.damper;
    const Floats length = sqrt(dot(pull, pull));
    const Mask slips = length > limit;
    pull = select(slips, pull * (limit / max(length, all(1e-30f))), pull);
    at = select(slips, (pull - speed * spring.damper) * (1.0f / spring.stiffness), at);
    return pull;
  }

  MOTES_INLINE Push push(const Touching& t, Floats3& slid, Floats3& rolled) const {
    const Floats mass = 1.0f / max(t.own.inverse + t.other.inverse, all(1e-30f));
    const Floats most = mass * (kMostStiff / (step * step));
    const Floats stiff = min(stiffness, most);
    const Floats damper = damping * sqrt(stiff * mass);
    const Spring surface{stiff * kAlong, damper * kAlongDamping};
    const Floats along = dot(t.apart, t.normal);
    const Floats out = stiff * t.overlap - damper * along;
    const Floats pressed = max(out, Floats{});
    // The point of contact is halfway between both surfaces.
    const Floats arm = t.own.radius - 0.5f * t.overlap;
    const Floats3 turning = t.spin * arm + t.other_spin * (t.other.radius - 0.5f * t.overlap);
    const Floats3 slide = t.apart - t.normal * along - cross(turning, t.normal);
    slid = slid - t.normal * dot(slid, t.normal);  // projects onto the contact plane, which has turned
    const Floats3 drag = held(surface, slid, slide, friction * pressed);
    const Floats both = t.own.radius * t.other.radius / max(t.own.radius + t.other.radius, all(1e-30f));
    const Floats3 roll = cross(t.spin - t.other_spin, t.normal) * both;
    rolled = rolled - t.normal * dot(rolled, t.normal);
    const Floats3 brake = held(surface, rolled, roll, rolling_friction * pressed);
    return {drag - t.normal * out, cross(t.normal, drag) * arm - cross(t.normal, brake) * both, most < stiffness};
  }

  struct Sums {
    // Touches are listed first and computed when all are known, or when the list is full, so that all lanes have work.
    static constexpr std::uint32_t kListed = 16;
    std::uint32_t first;
    Floats3 at, velocity, spin, sum{}, turn{};
    Inertia own;
    std::uint32_t listed[kLanes] = {}, most = 0;
    std::uint32_t place[kListed][kLanes];
    const particles::Touches* before[kLanes];
    particles::Touches after[kLanes];
    Ints touching{};
    Mask softened{};

    MOTES_INLINE Sums(const Contact&, const Task& task, std::uint32_t i, std::uint32_t last)
        : first(i), at(load_column(task.targets.column, interactions::at_x, i)),
          velocity(load_column(task.targets.column, interactions::velocity_x, i)),
          spin(load_column(task.targets.column, interactions::spin_x, i)),
          own{load(task.targets.column[interactions::radius] + i),
              load(task.targets.column[interactions::inverse_mass] + i)} {
      for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
        before[lane] = nullptr;
        after[lane].count = 0;
        if (i + lane >= last) {  // belongs to another row (maybe another thread's), or is no particle
          own.radius[lane] = 0;
          continue;
        }
        const std::uint32_t index = task.targets.cells.order[i + lane];
        if (index >= task.targets.cells.own) continue;
        const particles::Touches& own_touches = task.touches[index];
        if (task.now - own_touches.step == 1) before[lane] = &own_touches;
      }
    }

    MOTES_INLINE void add(const Contact& law, const Task& task, std::uint32_t j) {
      const float* const* column = task.sources.column;
      const Floats3 r = seen_from(at, column, j);
      const Floats r2 = dot(r, r);
      const Floats reach = own.radius + column[interactions::radius][j];
      const Mask near = (r2 < reach * reach) & (own.radius > 0.0f) & (all(column[interactions::radius][j]) > 0.0f);
      if (!any(near)) return;
      for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
        if (near[lane] == 0 || first + lane == j) continue;
        place[listed[lane]][lane] = j;
        ++touching[lane];
        if (++listed[lane] > most) most = listed[lane];
      }
      if (most == kListed) compute(law, task);
    }

    /// Computes all listed touches, the n-th of each target at a time.
    __attribute__((noinline)) void compute(const Contact& law, const Task& task) {
      for (std::uint32_t n = 0; n < most; ++n) add_touch(law, task, n);
      most = 0;
      for (std::uint32_t& count : listed) count = 0;
    }

    MOTES_INLINE void add_touch(const Contact& law, const Task& task, std::uint32_t n) {
      const float* const* column = task.sources.column;
      std::uint32_t j[kLanes];
      Mask here{};
      for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
        here[lane] = n < listed[lane] ? -1 : 0;
        j[lane] = n < listed[lane] ? place[n][lane] : first;
      }
      const auto of = [&](int number) {
        Floats v;
        for (std::uint32_t lane = 0; lane < kLanes; ++lane) v[lane] = column[number][j[lane]];
        return v;
      };
      const auto of3 = [&](int number) { return Floats3{of(number), of(number + 1), of(number + 2)}; };
      Touching t{};
      const Floats3 r = of3(interactions::at_x) - at;
      const Floats d = sqrt(dot(r, r));
      t.normal = r * (1.0f / d);
      t.own = own;
      t.other = {of(interactions::radius), of(interactions::inverse_mass)};
      t.overlap = own.radius + t.other.radius - d;
      t.apart = of3(interactions::velocity_x) - velocity;
      t.spin = spin;
      t.other_spin = of3(interactions::spin_x);
      std::uint64_t id[kLanes];
      Floats3 slid{}, rolled{};
      for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
        if (here[lane] == 0) continue;
        id[lane] = id_of(task.sources, j[lane]);
        if (!(d[lane] > 0)) set_lane(t.normal, lane, parting(id_of(task.targets, first + lane), id[lane], 0));
        if (before[lane] != nullptr) recall(*before[lane], id[lane], lane, slid, rolled);
      }
      const Push push = law.push(t, slid, rolled);
      softened |= here & push.softened;
      sum = sum + only(here, push.force * (law.step * own.inverse));
      turn = turn + only(here, push.torque * (law.step * own.inverse_moment()));
      for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
        if (here[lane] != 0) remember(after[lane], id[lane], lane, slid, rolled);
      }
    }

    static void recall(const particles::Touches& before, std::uint64_t id, std::uint32_t lane, Floats3& slid,
                       Floats3& rolled) {
      for (std::uint32_t k = 0; k < before.count; ++k) {
        const particles::Touch& touch = before.touch[k];
        if (touch.id != id) continue;
        set_lane(slid, lane, of(touch.slid));
        set_lane(rolled, lane, of(touch.rolled));
        return;
      }
    }

    // Remembers a touch; beyond kMost it is felt but not remembered.
    static void remember(particles::Touches& after, std::uint64_t id, std::uint32_t lane, const Floats3& slid,
                         const Floats3& rolled) {
      if (after.count == particles::Touches::kMost) return;
      after.touch[after.count++] = {
          id, {slid.x[lane], slid.y[lane], slid.z[lane]}, {rolled.x[lane], rolled.y[lane], rolled.z[lane]}};
    }

    MOTES_INLINE void finish(const Contact& law, const Task& task, const Around&, std::uint32_t i, std::uint32_t last) {
      compute(law, task);
      const Floats3 now = velocity + sum, turned = spin + turn;
      store_lanes3(task.out, i, now, last - i);
      store_lanes3(task.out + 3, i, turned, last - i);
      store_lanes(task.out[6] + i, to_floats(touching), last - i);
      for (std::uint32_t k = i; k < last; ++k) {
        const std::uint32_t index = task.targets.cells.order[k];
        if (index >= task.targets.cells.own || (task.chosen != nullptr && task.chosen[index] == 0)) continue;
        // Another contact of this sub-step remembers already: its springs are not those of this one.
        if (task.touches[index].step == task.now) continue;
        after[k - i].step = task.now;
        task.touches[index] = after[k - i];
      }
      task.stats->pairs += sum_own(task.targets.cells, touching, i, last);
      task.stats->softened = task.stats->softened || any(softened);
    }
  };
};

/// Returns twice the part of critical damping that gives this restitution in a head-on collision.
MOTES_INLINE Floats damping_of(float restitution) {
  if (!(restitution > 1e-30f)) return all(2.0f);
  const Floats l = log(all(restitution));
  return -2.0f * l / sqrt(9.8696044f + l * l);
}

inline void contact(const Task& task) {
  const auto n = numbers_of<numbers::contact>(task);
  sweep(task,
        Contact{all(task.dt), all(n.stiffness), damping_of(n.restitution), all(n.friction), all(n.rolling_friction)});
}

namespace laws {
inline constexpr interactions::Law contact = {
    .act = MOTES_ISA::contact,
    .radius = [](const double* recorded, bool) { return actions::read_numbers<numbers::contact>(recorded).radius; },
    .inverse_masses = true,
    .skips_massless = true,
    .remembers = true,
};
}  // namespace laws

}  // namespace motes::MOTES_ISA
