// Touches of spheres with walls: the law of contact, with an infinitely heavy and flat wall.
#pragma once

#include "interactions/laws/touch_lanes.h"
#include "shapes/nearest.h"

namespace motes::MOTES_ISA {

/// Returns whether the particle at a place is this rank's own and may change.
MOTES_INLINE bool may_change(const interactions::WallTask& task, std::uint32_t place) {
  const std::uint32_t i = task.order[place];
  return i < task.own && (task.chosen == nullptr || task.chosen[i] != 0);
}

/// Finds the places from task.first on that touch one wall; returns the first place that was not checked.
inline std::uint32_t find_walls(const interactions::WallTask& task, interactions::WallTouches& found) {
  std::uint32_t next = task.last;  // for a shape without a surface
  visit_feet(*task.wall, task.start, [&](const auto& feet) __attribute__((always_inline)) {
    std::uint32_t i = task.first;
    for (; i < task.last && found.count + kMostFaces * kLanes <= interactions::WallTouches::kMost; i += kLanes) {
      const Mask here = first_lanes(task.last - i);
      const FourWords at = load_fours([&](std::size_t lane) { return task.grains[i + lane].at; });
      const Floats radius = fourth(at);
      feet.each(three(at), [&](int face, const Foot& foot) __attribute__((always_inline)) {
        const Mask touches = foot.mask & here & (foot.distance < radius);
        if (!any(touches)) return;  // the usual case
        for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
          if (touches[lane] == 0 || !may_change(task, i + lane)) continue;
          const std::uint32_t n = found.count++;
          found.place[n] = i + lane;
          found.number[n] = task.number * kMostFaces + static_cast<std::uint32_t>(face);
          found.distance[n] = foot.distance[lane];
          found.towards[0][n] = foot.towards.x[lane];
          found.towards[1][n] = foot.towards.y[lane];
          found.towards[2][n] = foot.towards.z[lane];
        }
      });
    }
    next = i;
  });
  return next;
}

/// How a wall moves and deforms during a sub-step.
struct WallMotion {
  Pose start, end;
  Floats3 spin{};  // rad/s
  float per_step = 0;
  bool moves = false;
  const meshes::Deformation* deformation = nullptr;
  float when = 0, span = 0;  // of the sub-step, as fractions of the frame

  static MOTES_INLINE WallMotion of(const interactions::WallTask& task) {
    WallMotion motion{};
    const shapes::Shape& wall = *task.wall;
    if (wall.kind != shapes::Kind::mesh) return motion;
    motion.moves = shapes::changes_place(wall);
    motion.deformation = wall.deformation;
    if (!motion.moves && motion.deformation == nullptr) return motion;
    motion.start = pose_at(wall.number, task.start);
    motion.end = pose_at(wall.number, task.end);
    motion.per_step = 1.0f / task.dt;
    motion.when = task.start;
    motion.span = task.end - task.start;
    const Pose &a = motion.start, &b = motion.end;
    const Float3 x = cross(a.x, minus(b.x, a.x)), y = cross(a.y, minus(b.y, a.y)), z = cross(a.z, minus(b.z, a.z));
    motion.spin = all3(times(Float3{x.x + y.x + z.x, x.y + y.y + z.y, x.z + y.z + z.z}, 0.5f * motion.per_step));
    return motion;
  }
  /// Returns the velocity, m/s, of point `p` of the wall.
  MOTES_INLINE Floats3 velocity(Floats3 p) const {
    Floats3 v{};
    if (!moves && deformation == nullptr) return v;
    const Floats3 q = start.to_body(p);
    if (moves) v = (end.to_world(q) - start.to_world(q)) * per_step;
    if (deformation == nullptr) return v;
    return v + start.turn(DeformingLanes::from(*deformation).motion(q, all(when))) * (span * per_step);
  }
};

using WallPlane = float[interactions::WallTouches::kRoom];
MOTES_INLINE Floats3 load_three(const WallPlane* from, std::uint32_t n) {
  return {load(from[0] + n), load(from[1] + n), load(from[2] + n)};
}
MOTES_INLINE void store_three(WallPlane* to, std::uint32_t n, const Floats3& v) {
  store(to[0] + n, v.x);
  store(to[1] + n, v.y);
  store(to[2] + n, v.z);
}

/// Returns the point about which torques on a wall are computed: the first of the shape's numbers, or a mesh's origin.
MOTES_INLINE Floats3 origin_of(const shapes::Shape& shape, float part) {
  return all3(shape.kind == shapes::Kind::mesh ? pose_at(shape.number, part).position : of(shape.number));
}

/// Computes each touch's change of its particle, how far it has slid and rolled, and its force on the wall.
inline void push_walls(const interactions::WallTask& task, interactions::WallTouches& touches) {
  const Contact law = contact_of(task.numbers, task.dt);
  const WallMotion motion = WallMotion::of(task);
  const Floats3 origin = origin_of(*task.origin, task.start);
  for (std::uint32_t n = 0; n < touches.count; n += kLanes) {
    const LaneNumbers place(load_uints(touches.place + n) & (Uints)first_lanes(touches.count - n));
    const auto grain = [&](int quad) __attribute__((always_inline)) {
      return load_fours([&](std::size_t lane) { return task.grains[place.of[lane]].at + 4 * quad; });
    };
    const FourWords i_at = grain(0), i_velocity = grain(1);
    Touching t{};
    t.normal = load_three(touches.towards, n);
    t.own = {fourth(i_at), fourth(i_velocity)};
    t.other = {all(1e15f), Floats{}};
    t.overlap = t.own.radius - load(touches.distance + n);
    // Relative to a wall that turns around the particle's centre: the relative speed of the surfaces is the same.
    const Floats3 at = three(i_at);
    t.apart = motion.velocity(at) - three(i_velocity);
    t.spin = three(grain(2)) - motion.spin;
    Floats3 slid = load_three(touches.slid, n), rolled = load_three(touches.rolled, n);
    const Push push = law.push(t, slid, rolled);
    store_three(touches.change, n, law.speed(push));
    store_three(touches.change + 3, n, law.turn(push));
    store_three(touches.slid, n, slid);
    store_three(touches.rolled, n, rolled);
    store_three(touches.force, n, law.newtons(push.force * -1.0f, push));
    store_three(touches.torque, n, law.newtons((cross(at - origin, push.force) + push.torque()) * -1.0f, push));
  }
}

}  // namespace motes::MOTES_ISA
