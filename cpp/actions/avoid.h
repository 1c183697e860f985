// avoid: particles that would meet the shape within look_ahead seconds are turned; their speed stays. With t the time
// until then:
//   v' = |v| unit(unit(v) + aside magnitude dt / (q^2 + epsilon))
// after McAllister's Avoid, whose q and unit vector aside are
//   Plane                 q = t              aside = the part of v along the plane
//   Rectangle, Triangle   q = t              aside = from the place of the hit to the nearest edge
//   Disc                  q = t              aside = from the centre to the place of the hit
//   Sphere, from outside  q = |v| t          aside = away from the centre, across v
// and by the plane's idea, taken at the place of the hit:
//   Box, Cylinder, Cone, from outside  q = t  aside = the part of v along the surface
// Of a Union, the part that would be met first counts. Whoever heads straight at it, where there is no aside, goes on.
#pragma once

#include "actions/lanes.h"
#include "shapes/triangle.h"

namespace motes::MOTES_ISA {

struct Turn {
  Mask mask;
  Floats time, q;
  Floats3 aside;  // of any length
};

/// The part of v along a surface.
MOTES_INLINE Floats3 along_surface(Floats3 v, Floats3 normal) { return v - normal * dot(v, normal); }

MOTES_INLINE Turn turn_at(const PlaneLanes& plane, Floats3 x, Floats3 v, float look_ahead) {
  const Crossing crossing = cross_plane(plane.point, plane.normal, x, v * look_ahead);
  const Floats time = crossing.part * look_ahead;
  return {crossing.mask, time, time, along_surface(v, crossing.normal)};
}

MOTES_INLINE Turn turn_at(const DiscLanes& disc, Floats3 x, Floats3 v, float look_ahead) {
  const Hit hit = disc.hit(x, v * look_ahead);
  const Floats time = hit.part * look_ahead;
  return {hit.mask, time, time, x + v * time - all3(disc.center)};
}

MOTES_INLINE Turn turn_at(const SphereLanes& sphere, Floats3 x, Floats3 v, float look_ahead) {
  const Hit hit = sphere.hit(x, v * look_ahead);
  const Floats time = hit.part * look_ahead;
  const Floats3 from_center = x - all3(sphere.center);
  const Floats speed2 = dot(v, v);
  const Mask outside = dot(from_center, from_center) > sphere.radius * sphere.radius;
  const Floats3 across = from_center - v * (dot(from_center, v) / max(speed2, all(1e-30f)));
  return {hit.mask & outside, time, sqrt(speed2) * time, across};
}

template <class Solid>
MOTES_INLINE Turn turn_at(const Solid& solid, Floats3 x, Floats3 v, float look_ahead) {
  const Hit hit = solid.hit(x, v * look_ahead);
  const Floats time = hit.part * look_ahead;
  return {hit.mask & ~solid.contains(x), time, time, along_surface(v, hit.normal)};
}

/// The way to the nearest edge of origin + a u + b v: lines a = 0, b = 0 and either a = 1, b = 1 or a + b = 1.
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
    Floats least = all(__builtin_inff());
    Floats3 way{};
    nearer(a, times(to_a, -1.0f), least, way);
    nearer(b, times(to_b, -1.0f), least, way);
    if (triangle) {
      nearer(1.0f - a - b, {to_a.x + to_b.x, to_a.y + to_b.y, to_a.z + to_b.z}, least, way);
    } else {
      nearer(1.0f - a, to_a, least, way);
      nearer(1.0f - b, to_b, least, way);
    }
    return way;
  }

 private:
  /// The edge is where `left`, which falls by |gradient| a metre along `gradient`, is 0.
  static MOTES_INLINE void nearer(Floats left, Float3 gradient, Floats& least, Floats3& way) {
    const Floats distance = left * (1.0f / __builtin_sqrtf(dot(gradient, gradient)));
    const Mask mask = distance < least;
    least = select(mask, distance, least);
    way = select(mask, all3(unit(gradient)), way);
  }
};

template <class Flat>
MOTES_INLINE Turn turn_to_edge(const Flat& flat, bool triangle, Floats3 x, Floats3 v, float look_ahead) {
  const Hit hit = flat.hit(x, v * look_ahead);
  const Floats time = hit.part * look_ahead;
  return {hit.mask, time, time, Edges::of(flat.origin, flat.u, flat.v, triangle).nearest(x + v * time)};
}

// One copy for all callers: a union calls it for each part.
__attribute__((noinline)) inline Turn turn_from(const shapes::Shape& shape, Floats3 x, Floats3 v, float look_ahead) {
  if (shape.kind == shapes::Kind::rectangle) {
    return turn_to_edge(RectangleLanes::from(shape), false, x, v, look_ahead);
  }
  if (shape.kind == shapes::Kind::triangle) {
    return turn_to_edge(TriangleLanes::from(shape), true, x, v, look_ahead);
  }
  Turn turn;
  visit(shape, [&](const auto& lanes) __attribute__((always_inline)) { turn = turn_at(lanes, x, v, look_ahead); });
  return turn;
}

MOTES_INLINE Turn first_turn(const shapes::Shape& shape, Floats3 x, Floats3 v, float look_ahead) {
  if (shape.kind != shapes::Kind::united) return turn_from(shape, x, v, look_ahead);
  Turn first = turn_from(shape.part[0], x, v, look_ahead);
  for (int k = 1; k < shape.parts; ++k) {
    const Turn turn = turn_from(shape.part[k], x, v, look_ahead);
    const Mask sooner = turn.mask & (~first.mask | (turn.time < first.time));
    first = {first.mask | turn.mask, select(sooner, turn.time, first.time), select(sooner, turn.q, first.q),
             select(sooner, turn.aside, first.aside)};
  }
  return first;
}

inline void avoid(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const float strength = number(p, 0) * s.dt;
  const float epsilon = number(p, 1);
  const float look_ahead = number(p, 2);
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 v = load3(b, kVelocityAt, i);
    const Turn turn = first_turn(*p.shape, load3(b, kPositionAt, i), v, look_ahead);
    if (!any(turn.mask)) continue;
    const Floats speed = sqrt(dot(v, v));
    const Floats length2 = dot(turn.aside, turn.aside);
    const Floats part = strength / (turn.q * turn.q + epsilon);
    const Floats3 turned = v + turn.aside * (part * speed / sqrt(length2));
    const Floats turned2 = dot(turned, turned);
    const Mask mask = turn.mask & (length2 > 0.0f) & (turned2 > 0.0f);
    store3(b, kVelocityAt, i, select(mask, turned * (speed / sqrt(turned2)), v));
  }
}

}  // namespace motes::MOTES_ISA
