// Clumps as rigid bodies: places their spheres in space, and moves each clump by the pushes on its spheres.
#pragma once

#include "interactions/sweep.h"
#include "simd/rotations.h"

namespace motes::MOTES_ISA {

/// The body axes of a vector of clumps, in world coordinates.
struct ClumpAxes {
  Floats3 x, y, z;

  static MOTES_INLINE ClumpAxes of(Rotations q) { return {turned_x(q), turned_y(q), turned_z(q)}; }
  MOTES_INLINE Floats3 to_world(Floats3 v) const { return x * v.x + y * v.y + z * v.z; }
  MOTES_INLINE Floats3 to_body(Floats3 v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
  /// Returns the vector from a clump's centre to that of one of its spheres, in world coordinates.
  MOTES_INLINE Floats3 arm(const interactions::ClumpSphere& sphere, Floats size) const {
    return to_world(Floats3{size * sphere.at[0], size * sphere.at[1], size * sphere.at[2]});
  }
  /// Multiplies a vector in world coordinates by a symmetric tensor in body axes (xx, yy, zz, xy, xz, yz).
  MOTES_INLINE Floats3 apply(const float (&tensor)[6], Floats3 v) const {
    const Floats3 b = to_body(v);
    return to_world({b.x * tensor[0] + b.y * tensor[3] + b.z * tensor[4],
                     b.x * tensor[3] + b.y * tensor[1] + b.z * tensor[5],
                     b.x * tensor[4] + b.y * tensor[5] + b.z * tensor[2]});
  }
};

MOTES_INLINE Rotations orientation_at(const interactions::ClumpTask& task, std::size_t i) {
  const float* const* q = task.column + interactions::clump_orientation;
  return unit(Rotations{load(q[0] + i), load(q[1] + i), load(q[2] + i), load(q[3] + i)});
}
MOTES_INLINE Floats3 load_clumps(const interactions::ClumpTask& task, int first, std::size_t i) {
  return load_column(task.column, first, static_cast<std::uint32_t>(i));
}

/// Computes position, velocity, spin, size and mass of all spheres from those of their clumps.
inline void place_spheres(const interactions::ClumpTask& task) {
  for (std::size_t i = task.first; i < task.last; i += kLanes) {
    const auto lanes = static_cast<std::uint32_t>(task.last - i < kLanes ? task.last - i : kLanes);
    const ClumpAxes axes = ClumpAxes::of(orientation_at(task, i));
    const Floats size = load(task.column[interactions::clump_size] + i);
    const Floats mass = load(task.column[interactions::clump_mass] + i);
    const Floats3 at = load_clumps(task, interactions::clump_x, i);
    const Floats3 velocity = load_clumps(task, interactions::clump_velocity, i);
    const Floats3 spin = load_clumps(task, interactions::clump_spin, i);
    for (std::size_t k = 0; k < task.count; ++k) {
      const auto to = static_cast<std::uint32_t>(k * task.stride + i);
      const Floats3 arm = axes.arm(task.spheres[k], size);
      store_lanes3(task.placed + interactions::sphere_x, to, at + arm, lanes);
      store_lanes3(task.placed + interactions::sphere_velocity, to, velocity + cross(spin, arm), lanes);
      store_lanes3(task.placed + interactions::sphere_spin, to, spin, lanes);
      store_lanes(task.placed[interactions::sphere_size] + to, size * (2 * task.spheres[k].radius), lanes);
      store_lanes(task.placed[interactions::sphere_mass] + to, mass, lanes);
    }
  }
}

/// Sums the pushes on the spheres of a clump, per kilogram, in the order of the spheres.
struct ClumpPush {
  Floats3 velocity{}, torque{};
  Floats touches{};

  MOTES_INLINE void add(const interactions::ClumpTask& task, std::size_t k, std::size_t i, Floats3 arm, Floats size) {
    const auto from = static_cast<std::uint32_t>(k * task.stride + i);
    const Floats3 push = load_column(task.sums, 0, from);
    const Floats radius = size * task.spheres[k].radius;
    velocity = velocity + push;
    torque = torque + cross(arm, push) + load_column(task.sums, 3, from) * (radius * radius * 0.4f);
    touches += load(task.sums[6] + from);
  }
};

/// Writes velocities and spins of clumps after the pushes on all their spheres. `move` turns a clump by one spin during
/// the whole step, so the spin is computed for the middle of the step: this conserves angular momentum up to rounding,
/// and energy does not drift. The spin before the pushes is that of the last step's middle or, after an earlier contact
/// of this sub-step, of this step's. The spin is found by fixed-point iteration; a clump turns by less than a radian
/// per step, so a few iterations suffice.
inline void turn_clumps(const interactions::ClumpTask& task) {
  constexpr int kIterations = 5;
  const float half = 0.5f * task.dt;
  for (std::size_t i = task.first; i < task.last; i += kLanes) {
    const auto lanes = static_cast<std::uint32_t>(task.last - i < kLanes ? task.last - i : kLanes);
    const Rotations q = orientation_at(task, i);
    const ClumpAxes axes = ClumpAxes::of(q);
    const Floats size = load(task.column[interactions::clump_size] + i);
    const Floats3 before = load_clumps(task, interactions::clump_spin, i);
    ClumpPush push;
    for (std::size_t k = 0; k < task.count; ++k) push.add(task, k, i, axes.arm(task.spheres[k], size), size);
    const auto middle = [&](Floats3 spin, Floats time) __attribute__((always_inline)) {
      return ClumpAxes::of(unit(rotation_by(spin * time) * q));
    };
    const Floats3 momentum =
        middle(before, select(load(task.turned + i) > 0.0f, all(half), all(-half))).apply(task.inertia, before) +
        push.torque * (1.0f / max(size * size, all(1e-30f)));
    Floats3 spin = before;
    for (int n = 0; n < kIterations; ++n) spin = middle(spin, all(half)).apply(task.inverse, momentum);
    spin = select(finite(spin), spin, before);
    const auto to = static_cast<std::uint32_t>(i);
    store_lanes3(task.out, to, load_clumps(task, interactions::clump_velocity, i) + push.velocity, lanes);
    store_lanes3(task.out + 3, to, spin, lanes);
    store_lanes(task.out[6] + to, push.touches, lanes);
  }
}

}  // namespace motes::MOTES_ISA
