// avoid: turns particles that would meet the shape within look_ahead seconds, without changing their speed. With t the
// time until the hit:
//   v' = |v| unit(unit(v) + aside magnitude dt / (q^2 + epsilon))
// after McAllister's Avoid, whose q and unit vector aside are
//   Plane                 q = t              aside = the part of v along the plane
//   Rectangle, Triangle   q = t              aside = from the hit to the nearest edge
//   Disc                  q = t              aside = from the centre to the hit
//   Sphere, from outside  q = |v| t          aside = away from the centre, across v
// and by analogy, from outside:
//   Box                   as a Rectangle: the face that is hit
//   Cylinder, Cone        wall: as the tangent Plane at the hit; flat ends: as a Disc
//   Mesh                  as the tangent Plane at the hit
// For a Union, the part that is hit first counts. A particle that heads straight at the shape has no direction aside
// and is not turned.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

struct Detour {
  Mask mask;
  Floats time, q;
  Floats3 aside;  // of any length
};

/// The component of v along a surface.
MOTES_INLINE Floats3 along_surface(Floats3 v, Floats3 normal) { return v - normal * dot(v, normal); }

MOTES_INLINE Detour turn_at(const PlaneLanes& plane, Floats3 x, Floats3 v, float look_ahead) {
  const PlaneCrossing crossing = cross_plane(plane.point, plane.normal, x, v * look_ahead);
  const Floats time = crossing.part * look_ahead;
  return {crossing.mask, time, time, along_surface(v, crossing.normal)};
}

MOTES_INLINE Detour turn_at(const DiscLanes& disc, Floats3 x, Floats3 v, float look_ahead) {
  const Hit hit = disc.hit(x, v * look_ahead);
  const Floats time = hit.part * look_ahead;
  return {hit.mask, time, time, x + v * time - all3(disc.center)};
}

MOTES_INLINE Detour turn_at(const SphereLanes& sphere, Floats3 x, Floats3 v, float look_ahead) {
  const Hit hit = sphere.hit(x, v * look_ahead);
  const Floats time = hit.part * look_ahead;
  const Floats3 from_center = x - all3(sphere.center);
  const Floats speed2 = dot(v, v);
  const Mask outside = dot(from_center, from_center) > sphere.radius * sphere.radius;
  const Floats3 across = from_center - v * (dot(from_center, v) / max(speed2, all(__FLT_MIN__)));
  return {hit.mask & outside, time, sqrt(speed2) * time, across};
}

/// The nearest edge so far, and the direction to it.
struct NearestFace {
  Floats distance;
  Floats3 way;

  MOTES_INLINE void see(Floats other, Floats3 other_way) {
    const Mask mask = other < distance;
    distance = select(mask, other, distance);
    way = select(mask, other_way, way);
  }
};
MOTES_INLINE NearestFace nothing_near() { return {all(__builtin_inff()), all3(Float3{0, 0, 0})}; }

MOTES_INLINE Detour turn_at(const BoxLanes& box, Floats3 x, Floats3 v, float look_ahead) {
  const Hit hit = box.hit(x, v * look_ahead);
  const Floats time = hit.part * look_ahead;
  const Floats3 at = x + v * time;
  const Floats never = all(__builtin_inff());
  const Mask along_x = hit.normal.x == 0.0f, along_y = hit.normal.y == 0.0f, along_z = hit.normal.z == 0.0f;
  NearestFace edge = nothing_near();
  edge.see(select(along_x, at.x - box.low.x, never), all3(Float3{-1, 0, 0}));
  edge.see(select(along_x, box.high.x - at.x, never), all3(Float3{1, 0, 0}));
  edge.see(select(along_y, at.y - box.low.y, never), all3(Float3{0, -1, 0}));
  edge.see(select(along_y, box.high.y - at.y, never), all3(Float3{0, 1, 0}));
  edge.see(select(along_z, at.z - box.low.z, never), all3(Float3{0, 0, -1}));
  edge.see(select(along_z, box.high.z - at.z, never), all3(Float3{0, 0, 1}));
  return {hit.mask & ~box.contains(x), time, time, edge.way};
}

/// Returns the turn at a cylinder or cone around the axis from `start` to `end`.
template <class Round>
MOTES_INLINE Detour turn_round(const Round& round, Float3 start, Float3 end, Floats3 x, Floats3 v, float look_ahead) {
  const Hit hit = round.hit(x, v * look_ahead);
  const Floats time = hit.part * look_ahead;
  const Floats3 axis = all3(unit(minus(end, start)));
  const Floats3 at = x + v * time - all3(start);
  const Mask flat_end = abs(dot(hit.normal, axis)) > 0.9999f;
  const Floats3 aside = select(flat_end, at - axis * dot(at, axis), along_surface(v, hit.normal));
  return {hit.mask & ~round.contains(x), time, time, aside};
}

/// Finds the direction to the nearest edge of origin + a u + b v, whose edges are the lines a = 0, b = 0 and either
/// a = 1, b = 1 or a + b = 1.
struct Edges {
  Float3 origin, to_a, to_b;  // to_a, to_b: reciprocal vectors, so a = (x - origin) to_a
  bool triangle;

  static MOTES_INLINE Edges of(Float3 origin, Float3 u, Float3 v, bool triangle) {
    const Float3 uxv = cross(u, v);
    const float scale = 1.0f / dot(uxv, uxv);
    return {origin, times(cross(v, uxv), scale), times(cross(uxv, u), scale), triangle};
  }

  MOTES_INLINE Floats3 nearest(Floats3 at) const {
    const Floats a = dot(at - all3(origin), all3(to_a)), b = dot(at - all3(origin), all3(to_b));
    NearestFace edge = nothing_near();
    see(edge, a, times(to_a, -1.0f));
    see(edge, b, times(to_b, -1.0f));
    if (triangle) {
      see(edge, 1.0f - a - b, {to_a.x + to_b.x, to_a.y + to_b.y, to_a.z + to_b.z});
    } else {
      see(edge, 1.0f - a, to_a);
      see(edge, 1.0f - b, to_b);
    }
    return edge.way;
  }

 private:
  /// `left` is 0 at the edge and falls by |gradient| per metre along `gradient`.
  static MOTES_INLINE void see(NearestFace& edge, Floats left, Float3 gradient) {
    edge.see(left * (1.0f / __builtin_sqrtf(dot(gradient, gradient))), all3(unit(gradient)));
  }
};

template <class Flat>
MOTES_INLINE Detour turn_to_edge(const Flat& flat, bool triangle, Floats3 x, Floats3 v, float look_ahead) {
  const Hit hit = flat.hit(x, v * look_ahead);
  const Floats time = hit.part * look_ahead;
  return {hit.mask, time, time, Edges::of(flat.origin, flat.u, flat.v, triangle).nearest(x + v * time)};
}

MOTES_INLINE Detour turn_at_mesh(const shapes::Shape& s, Floats3 x, Floats3 v, float look_ahead) {
  const RareLanes mesh = RareLanes::from(s);
  const Hit hit = mesh.hit(x, v * look_ahead);
  const Floats time = hit.part * look_ahead;
  return {hit.mask & ~mesh.contains(x), time, time, along_surface(v, hit.normal)};
}

// One copy for all callers: a union calls it for each part.
__attribute__((noinline)) inline Detour turn_from(const shapes::Shape& s, Floats3 x, Floats3 v, float look_ahead) {
  using shapes::Kind;
  const auto axial = s.as<shapes::numbers::axial>();
  const Float3 start = of(axial.start), end = of(axial.end);
  switch (s.kind) {
    case Kind::rectangle: return turn_to_edge(RectangleLanes::from(s), false, x, v, look_ahead);
    case Kind::triangle: return turn_to_edge(TriangleLanes::from(s), true, x, v, look_ahead);
    case Kind::disc: return turn_at(DiscLanes::from(s), x, v, look_ahead);
    case Kind::sphere: return turn_at(SphereLanes::from(s), x, v, look_ahead);
    case Kind::box: return turn_at(BoxLanes::from(s), x, v, look_ahead);
    case Kind::cylinder: return turn_round(CylinderLanes::from(s), start, end, x, v, look_ahead);
    case Kind::cone: return turn_round(ConeLanes::from(s), start, end, x, v, look_ahead);
    case Kind::plane: return turn_at(PlaneLanes::from(s), x, v, look_ahead);
    case Kind::mesh: return turn_at_mesh(s, x, v, look_ahead);
    // Recording refuses these, as they have no surface. A union is handled part by part.
    case Kind::point:
    case Kind::line:
    case Kind::blob:
    case Kind::united: break;
  }
  return {Mask{}, Floats{}, Floats{}, {Floats{}, Floats{}, Floats{}}};
}

MOTES_INLINE Detour first_turn(const shapes::Shape& shape, Floats3 x, Floats3 v, float look_ahead) {
  if (shape.kind != shapes::Kind::united) return turn_from(shape, x, v, look_ahead);
  Detour first = turn_from(shape.part[0], x, v, look_ahead);
  for (int k = 1; k < shape.parts; ++k) {
    const Detour turn = turn_from(shape.part[k], x, v, look_ahead);
    const Mask sooner = turn.mask & (~first.mask | (turn.time < first.time));
    first = {first.mask | turn.mask, select(sooner, turn.time, first.time), select(sooner, turn.q, first.q),
             select(sooner, turn.aside, first.aside)};
  }
  return first;
}

/// Turns all particles of a block; turn_of(positions, velocities) returns the turn of a vector.
template <class TurnOf>
MOTES_INLINE void avoid_all(const actions::Parameters& p, const actions::Block& b, const actions::Step& s,
                            const TurnOf& turn_of) {
  const auto n = numbers_of<numbers::avoid>(p);
  const float strength = n.magnitude * s.dt;
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 v = load3(b, kVelocityAt, i);
    const Detour turn = turn_of(load3(b, kPositionAt, i), v);
    if (!any(turn.mask)) continue;
    const Floats speed = sqrt(dot(v, v));
    const Floats length2 = dot(turn.aside, turn.aside);
    const Floats part = strength / (turn.q * turn.q + n.epsilon);
    const Floats length = sqrt(length2);
    Floats3 turned = v + turn.aside * (part * speed / length);
    // At the surface and without epsilon the sum overflows: take the direction aside.
    turned = select(dot(turned, turned) <= __FLT_MAX__, turned, turn.aside * (1.0f / length));
    const Floats turned2 = dot(turned, turned);
    const Floats3 after = turned * (speed / sqrt(turned2));
    const Mask mask = turn.mask & (length2 > 0.0f) & (turned2 > 0.0f) & finite(after);
    store3(b, kVelocityAt, i, select(mask, after, v));
  }
}

inline void avoid(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const shapes::Shape& shape = *p.shape;
  const float look_ahead = numbers_of<numbers::avoid>(p).look_ahead;
  const auto inlined = [&](const auto& lanes) __attribute__((always_inline)) {
    avoid_all(p, b, s,
              [&](Floats3 x, Floats3 v) __attribute__((always_inline)) { return turn_at(lanes, x, v, look_ahead); });
  };
  using shapes::Kind;
  if (shape.kind == Kind::plane) return inlined(PlaneLanes::from(shape));  // the most common case
  if (shape.kind == Kind::sphere) return inlined(SphereLanes::from(shape));
  if (shape.kind == Kind::box) return inlined(BoxLanes::from(shape));
  avoid_all(p, b, s,
            [&](Floats3 x, Floats3 v) __attribute__((always_inline)) { return first_turn(shape, x, v, look_ahead); });
}

}  // namespace motes::MOTES_ISA
