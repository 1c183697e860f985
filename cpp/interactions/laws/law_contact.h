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
  Floats3 force;
  Floats3 drags, brakes;    // the torque is drags * arm - brakes
  Floats arm;               // m, from the target's centre to the point of contact
  Inertia own;              // of the target
  Floats unit;              // the touch's unit of mass, as 1/kg
  Floats other_arm;
  Inertia other;            // of the source

  MOTES_INLINE Floats3 torque() const { return drags * arm - brakes; }
  /// Returns what the source gets: the opposite force, by bits the one that it would compute as a target.
  MOTES_INLINE Push back() const { return {force * -1.0f, drags, brakes * -1.0f, other_arm, other, unit, arm, own}; }
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
    const Inertia own{t.own.radius, t.own.inverse * to_units}, other{t.other.radius, t.other.inverse * to_units};
    const Floats mass = 1.0f / (own.inverse + other.inverse);
    const Floats stiff = min(max(stiffness * per_mass, all(1e-30f)), mass * (interactions::kMostStiff / (step * step)));
    const Floats damper = damping * sqrt(stiff * mass);
    const Spring surface{stiff * kAlong, damper * kAlongDamping,
                         inverse_power(power_of_two(min(own.radius, t.other.radius)))};
    const Floats3 apart = t.apart * unit, spin = t.spin * unit, other_spin = t.other_spin * unit;
    const Floats along = dot(apart, t.normal);
    const Floats far = min(own.radius, t.other.radius) * kFast;
    const Mask fast = dot(apart, apart) * (step * step) > far * far;
    const Floats out = select(fast, rebound * max(-along, Floats{}) * mass / step, stiff * t.overlap - damper * along);
    const Floats pressed = max(out, Floats{});
    // The point of contact is halfway between the two surfaces.
    const Floats arm = own.radius - 0.5f * t.overlap, other_arm = other.radius - 0.5f * t.overlap;
    const Floats3 turning = spin * arm + other_spin * other_arm;
    const Floats3 slide = apart - t.normal * along - cross(turning, t.normal);
    slid = slid - t.normal * dot(slid, t.normal);  // the normal has turned since
    const Floats3 drag = held(surface, slid, slide, friction * pressed);
    const Floats both = own.radius * t.other.radius / (own.radius + t.other.radius);
    const Floats3 roll = cross(spin - other_spin, t.normal) * both;
    rolled = rolled - t.normal * dot(rolled, t.normal);
    const Floats3 brake = held(surface, rolled, roll, rolling_friction * pressed);
    return {drag - t.normal * out,
            cross(t.normal, drag),
            cross(t.normal, brake) * both,
            arm,
            own,
            per_mass,
            other_arm,
            other};
  }
  /// Converts forces of a touch to newtons, and torques to newton metres.
  MOTES_INLINE Floats3 newtons(Floats3 force, const Push& push) const {
    return force * per_unit * inverse_power(push.unit) * per_unit;
  }
  /// Returns the change of the target's velocity, m/s.
  MOTES_INLINE Floats3 speed(const Push& push) const { return push.force * (step * push.own.inverse) * per_unit; }
  /// Returns the change of the target's rotational velocity, rad/s.
  MOTES_INLINE Floats3 turn(const Push& push) const {
    return push.torque() * (step * push.own.inverse_moment()) * per_unit;
  }
};

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

namespace laws {
/// Touches are computed by pair: see touch_lanes.h.
inline constexpr interactions::Law contact = {
    .radius = [](const double* recorded, bool) { return actions::read_numbers<numbers::contact>(recorded).radius; },
    .inverse_masses = true,
    .skips_massless = true,
    .remembers = true,
    .near = true,
    .between_systems = true,
};
/// Acts on the spheres of clumps: see kinds/touching.cpp. Radii are half of the size, which Touching scales to the
/// ball that encloses a clump.
inline constexpr interactions::Law contact_clumps = {
    .radius = [](const double*, bool) { return 0.0f; },
    .inverse_masses = true,
    .skips_massless = true,
    .remembers = true,
    .near = true,
    .between_systems = true,
};
}  // namespace laws

}  // namespace motes::MOTES_ISA
