// contact: discrete elements (Cundall and Strack 1979). Touching spheres push each other apart like springs with
// dampers. Springs along their surfaces, which remember how far the spheres have slid and rolled, hold them up to
// Coulomb's limit (Luding 2008, "Cohesive, frictional powders", treats sliding and rolling alike). Each touch is
// computed at both ends with opposite signs, so momentum and angular momentum are conserved.
#pragma once

#include "interactions/parting.h"
#include "interactions/sweep.h"
#include "simd/elementary.h"
#include "simd/squeeze.h"

namespace motes::MOTES_ISA {

/// Returns the largest power of two that is not above x, which must be positive and normal.
MOTES_INLINE Floats power_of_two(Floats x) { return (Floats)((Uints)x & 0x7f800000u); }
/// Returns 1 / x of a power of two, exactly.
MOTES_INLINE Floats inverse_power(Floats x) { return (Floats)(0x7f000000u - (Uints)x); }

/// A particle's resistance to being moved and turned.
struct Inertia {
  Floats radius, inverse;  // m, 1/kg

  /// Returns the inverse moment of inertia of a solid sphere, 1/(kg m2).
  MOTES_INLINE Floats inverse_moment() const { return 2.5f * inverse / (radius * radius); }
};

/// The geometry and motion of a touch, relative to the target.
struct Touching {
  Floats3 normal;  // towards the source
  Floats overlap;
  Floats3 apart;  // the source's velocity relative to the target
  Floats3 spin, other_spin;
  Inertia own, other;
};

/// The force and torque of a touch on its target, in the units of the touch: see Contact.
struct Push {
  Floats3 force, torque;
  Inertia own;   // of the target
  Floats unit;  // the touch's unit of mass, as 1/kg
};

/// A spring's stiffness and damping. `scale`: 1/m, a power of two that makes its pulls comparable to 1.
struct Spring {
  Floats stiffness, damper, scale;
};

/// The law, scale-free: grains of nanograms behave like asteroids. Squares of forces and moments of inertia would leave
/// float32's range, so forces are computed with a unit of mass near the reduced mass of each touch, and a unit of time
/// near the step. Units are powers of two, so they do not change any bit of the result.
struct Contact {
  Floats step;       // units of time
  Floats stiffness;  // kg per unit of time squared
  Floats damping, friction, rolling_friction;
  Floats rebound;  // 1 + restitution
  float unit, per_unit;  // the unit of time, s, and its inverse

  // Stiffness of the springs along the surface, relative to that between the centres. With two sevenths, colliding
  // spheres slide and slip back in one period (Schaefer et al. 1996, "Force schemes in simulations of granular
  // materials").
  static constexpr float kAlong = 2.0f / 7;
  static constexpr float kAlongDamping = 0.5f;
  // Part of the smaller radius. Two spheres that move farther in a step have no time to compress a spring, which would
  // push them by an overlap that they never worked for; they rebound at once.
  static constexpr float kFast = 0.2f;

  /// Stretches a surface spring for one step and returns its pull. `at`: its stretch, m, shortened where the pull would
  /// exceed `limit`; `speed`: rate of stretching, m per unit of time.
  MOTES_INLINE Floats3 held(Spring spring, Floats3& at, Floats3 speed, Floats limit) const {
    at = at + speed * step;
    Floats3 pull = at * spring.stiffness + speed * spring.damper;
    const Floats3 scaled = pull * spring.scale;
    const Floats length = sqrt(dot(scaled, scaled)), most = limit * spring.scale;
    const Mask slips = length > most;
    pull = select(slips, pull * (most / select(slips, length, all(1.0f))), pull);
    at = select(slips, (pull - speed * spring.damper) * (1.0f / spring.stiffness), at);
    return pull;
  }

  MOTES_INLINE Push push(const Touching& t, Floats3& slid, Floats3& rolled) const {
    const Floats per_mass = power_of_two(t.own.inverse + t.other.inverse), to_units = inverse_power(per_mass);
    const Inertia own{t.own.radius, t.own.inverse * to_units};
    const Floats mass = 1.0f / (own.inverse + t.other.inverse * to_units);
    const Floats stiff = min(max(stiffness * per_mass, all(1e-30f)), mass * (interactions::kMostStiff / (step * step)));
    const Floats damper = damping * sqrt(stiff * mass);
    const Spring surface{stiff * kAlong, damper * kAlongDamping, inverse_power(power_of_two(own.radius))};
    const Floats3 apart = t.apart * unit, spin = t.spin * unit, other_spin = t.other_spin * unit;
    const Floats along = dot(apart, t.normal);
    const Floats far = min(own.radius, t.other.radius) * kFast;
    const Mask fast = dot(apart, apart) * (step * step) > far * far;
    const Floats out = select(fast, rebound * max(-along, Floats{}) * mass / step, stiff * t.overlap - damper * along);
    const Floats pressed = max(out, Floats{});
    // The point of contact is halfway between the two surfaces.
    const Floats arm = own.radius - 0.5f * t.overlap;
    const Floats3 turning = spin * arm + other_spin * (t.other.radius - 0.5f * t.overlap);
    const Floats3 slide = apart - t.normal * along - cross(turning, t.normal);
    slid = slid - t.normal * dot(slid, t.normal);  // the normal has turned since
    const Floats3 drag = held(surface, slid, slide, friction * pressed);
    const Floats both = own.radius * t.other.radius / (own.radius + t.other.radius);
    const Floats3 roll = cross(spin - other_spin, t.normal) * both;
    rolled = rolled - t.normal * dot(rolled, t.normal);
    const Floats3 brake = held(surface, rolled, roll, rolling_friction * pressed);
    return {drag - t.normal * out, cross(t.normal, drag) * arm - cross(t.normal, brake) * both, own, per_mass};
  }
  /// Converts forces of a touch to newtons, and torques to newton metres.
  MOTES_INLINE Floats3 newtons(Floats3 force, const Push& push) const {
    return force * per_unit * inverse_power(push.unit) * per_unit;
  }
  /// Returns the change of the target's velocity, m/s.
  MOTES_INLINE Floats3 speed(const Push& push) const { return push.force * (step * push.own.inverse) * per_unit; }
  /// Returns the change of the target's rotational velocity, rad/s.
  MOTES_INLINE Floats3 turn(const Push& push) const {
    return push.torque * (step * push.own.inverse_moment()) * per_unit;
  }
};

/// Touching pairs of some targets, and their changes of the targets. Pairs are collected until there are many, then
/// computed one per lane.
struct TouchBatch {
  static constexpr std::uint32_t kMost = 256, kRoom = kMost + 2 * kLanes;

  std::uint32_t count = 0;
  alignas(64) std::uint32_t pair[kRoom], target[kRoom];
  alignas(64) float change[6][kRoom];  // of velocity and rotational velocity
};

MOTES_INLINE Floats take(const float* column, Uints at) { return gather(column, (Ints)at); }
MOTES_INLINE Floats3 take3(const float* const* column, int first, Uints at) {
  return {take(column[first], at), take(column[first + 1], at), take(column[first + 2], at)};
}

/// Adds the target's touching pairs from `pair` on, as many as fit; returns the next pair.
MOTES_INLINE std::uint32_t find_touches(const Task& task, std::uint32_t i, std::uint32_t pair, TouchBatch& batch) {
  const float* const* column = task.targets.column;
  const Floats3 at{all(column[interactions::at_x][i]), all(column[interactions::at_y][i]),
                   all(column[interactions::at_z][i])};
  const Floats own = all(column[interactions::radius][i]);
  const std::uint32_t end = task.pairs.begin[i + 1], before = batch.count;
  for (; pair < end && batch.count < TouchBatch::kMost; pair += kLanes) {
    const Mask here = first_lanes(end - pair);
    const Uints j = load_uints(task.pairs.second + pair) & (Uints)here;
    const Floats3 r = take3(column, interactions::at_x, j) - at;
    const Floats other = take(column[interactions::radius], j);
    const Floats reach = own + other;
    const Mask near = (dot(r, r) < reach * reach) & (min(own, other) > 0.0f) & here;
    batch.count += static_cast<std::uint32_t>(squeeze(batch.pair + batch.count, lane_numbers() + pair, near));
  }
  for (std::uint32_t k = before; k < batch.count; ++k) batch.target[k] = i;
  return pair < end ? pair : end;
}

MOTES_INLINE Floats3 remembered(const float* states, Ints at, Mask known) {
  return only(known, Floats3{gather(states, at), gather(states + 1, at), gather(states + 2, at)});
}

// Computes one vector of the batch, from `n` on.
MOTES_INLINE void compute_touches(const Contact& law, const Task& task, TouchBatch& batch, std::uint32_t n) {
  const float* const* column = task.targets.column;
  const Mask here = first_lanes(batch.count - n);
  const Uints pair = load_uints(batch.pair + n) & (Uints)here, i = load_uints(batch.target + n) & (Uints)here;
  const Uints j = (Uints)gather(reinterpret_cast<const float*>(task.pairs.second), (Ints)pair);
  Touching t{};
  const Floats3 r = take3(column, interactions::at_x, j) - take3(column, interactions::at_x, i);
  const Floats d = sqrt(dot(r, r));
  t.normal = r * (1.0f / d);
  t.own = {take(column[interactions::radius], i), take(column[interactions::inverse_mass], i)};
  t.other = {take(column[interactions::radius], j), take(column[interactions::inverse_mass], j)};
  t.overlap = t.own.radius + t.other.radius - d;
  t.apart = take3(column, interactions::velocity_x, j) - take3(column, interactions::velocity_x, i);
  t.spin = take3(column, interactions::spin_x, i);
  t.other_spin = take3(column, interactions::spin_x, j);
  const Mask together = ~(Mask)(d > 0.0f) & here;
  if (any(together)) {
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      if (together[lane] == 0) continue;
      set_lane(t.normal, lane, parting(task.pairs.ids[i[lane]], task.pairs.ids[j[lane]], task.side));
    }
  }
  static_assert(sizeof(interactions::PairState) == 8 * sizeof(float));
  const auto* states = reinterpret_cast<const float*>(task.pairs.state);
  const Ints at = (Ints)(pair << 3);
  const Mask known = (Mask)((Uints)gather(states + 6, at) + 1u == all_uints(task.now));
  Floats3 slid = remembered(states, at, known), rolled = remembered(states + 3, at, known);
  const Push push = law.push(t, slid, rolled);
  const Floats3 speed = law.speed(push), turn = law.turn(push);
  const Floats* const changes[6] = {&speed.x, &speed.y, &speed.z, &turn.x, &turn.y, &turn.z};
  for (int c = 0; c < 6; ++c) store(batch.change[c] + n, *changes[c]);
  for (std::uint32_t lane = 0; lane < kLanes && n + lane < batch.count; ++lane) {
    if (task.chosen != nullptr && task.chosen[task.targets.cells.order[i[lane]]] == 0) continue;
    interactions::PairState& state = task.pairs.state[pair[lane]];
    state.slid[0] = slid.x[lane], state.slid[1] = slid.y[lane], state.slid[2] = slid.z[lane];
    state.rolled[0] = rolled.x[lane], state.rolled[1] = rolled.y[lane], state.rolled[2] = rolled.z[lane];
    state.step = task.now;
  }
}

// Computes a batch and adds its changes to the targets, in the order of their pairs.
MOTES_INLINE void apply_touches(const Contact& law, const Task& task, TouchBatch& batch) {
  for (std::uint32_t n = 0; n < batch.count; n += kLanes) compute_touches(law, task, batch, n);
  for (std::uint32_t n = 0; n < batch.count; ++n) {
    const std::uint32_t i = batch.target[n];
    for (int c = 0; c < 3; ++c) {
      task.out[c][i] += batch.change[c][n];
      task.out[3 + c][i] += batch.change[3 + c][n];
    }
    task.out[6][i] += 1;
  }
  task.stats->pairs += batch.count;
  batch.count = 0;
}

/// Returns twice the damping ratio with which spheres that collide head-on rebound at `restitution` times their speed.
MOTES_INLINE Floats damping_of(float restitution) {
  if (!(restitution > 1e-30f)) return all(2.0f);
  const Floats l = log(all(restitution));
  return -2.0f * l / sqrt(9.8696044f + l * l);
}

inline Contact contact_of(const double* recorded, float dt) {
  const auto n = actions::read_numbers<numbers::contact>(recorded);
  const float unit = power_of_two(all(dt))[0];
  const double stiffness = double{n.stiffness} * unit * unit;
  const auto limited = static_cast<float>(stiffness < 1e-37 ? 1e-37 : stiffness > 1e37 ? 1e37 : stiffness);
  return {all(dt / unit),
          all(limited),
          damping_of(n.restitution),
          all(n.friction),
          all(n.rolling_friction),
          all(1.0f + n.restitution),
          unit,
          1.0f / unit};
}

// Sums begin with +0; the particle's own velocity and spin are added last.
inline void contact(const Task& task) {
  const Contact law = contact_of(task.numbers, task.dt);
  const std::uint32_t first = task.targets.cells.rows[task.first_row].first;
  const std::uint32_t last = task.targets.cells.rows[task.last_row].first;
  const std::size_t bytes = (last - first) * sizeof(float);
  for (int c = 0; c < 7; ++c) __builtin_memset(task.out[c] + first, 0, bytes);
  TouchBatch batch;
  for (std::uint32_t i = first; i < last; ++i) {
    for (std::uint32_t pair = task.pairs.begin[i]; pair < task.pairs.begin[i + 1];) {
      pair = find_touches(task, i, pair, batch);
      if (batch.count >= TouchBatch::kMost) apply_touches(law, task, batch);
    }
  }
  apply_touches(law, task, batch);
  if (task.sums_alone) return;
  for (int c = 0; c < 3; ++c) {
    const float* velocity = task.targets.column[interactions::velocity_x + c];
    const float* spin = task.targets.column[interactions::spin_x + c];
    for (std::uint32_t i = first; i < last; ++i) {
      task.out[c][i] = velocity[i] + task.out[c][i];
      task.out[3 + c][i] = spin[i] + task.out[3 + c][i];
    }
  }
}

namespace laws {
inline constexpr interactions::Law contact = {
    .act = MOTES_ISA::contact,
    .radius = [](const double* recorded, bool) { return actions::read_numbers<numbers::contact>(recorded).radius; },
    .inverse_masses = true,
    .skips_massless = true,
    .remembers = true,
    .between_systems = true,
};
/// Acts on the spheres of clumps: see kinds/touching.cpp. Radii are half of the size, which Touching scales to the
/// ball that encloses a clump.
inline constexpr interactions::Law contact_clumps = {
    .radius = [](const double*, bool) { return 0.0f; },
    .inverse_masses = true,
    .skips_massless = true,
    .remembers = true,
    .between_systems = true,
};
}  // namespace laws

}  // namespace motes::MOTES_ISA
