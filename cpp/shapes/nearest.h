// The points of a shape's surface that are nearest to places: where a sphere around a place touches the shape.
//
// Surfaces have two sides, and a sphere is held on the side of its centre. From outside, a convex body is touched at
// one point; from inside, as in a vessel, at each of its faces. A tube or a hollow cone is convex in any half plane
// through its axis, and is treated there like a convex body in space.
#pragma once

#include "shapes/all.h"  // written by CMake: all headers of shapes

namespace motes::MOTES_ISA {

/// The nearest point of a surface, or of one of its faces, relative to a place.
struct Foot {
  Mask mask;  // lanes that have such a point
  Floats distance;  // metres
  Floats3 towards;  // a unit vector
};

/// Returns the foot at the end of the vector `way`. `astray`: the direction to use if its length is 0.
MOTES_INLINE Foot foot_at(Mask mask, Floats3 way, Floats3 astray) {
  const Floats distance = sqrt(dot(way, way));
  const Mask apart = distance > 0.0f;
  return {mask, distance, select(apart, way * (1.0f / select(apart, distance, all(1.0f))), astray)};
}

/// Upper bound of face numbers: a box has six faces, plus the foot from outside.
inline constexpr std::uint32_t kMostFaces = 8;

// Each class below has each(p, use), which calls use(face, foot) for every face that a place may touch, with its
// number.

struct PlaneFeet {
  Float3 point, normal;

  static MOTES_INLINE PlaneFeet from(const shapes::Shape& s) {
    const auto plane = s.as<shapes::numbers::plane>();
    return {of(plane.point), unit(of(plane.normal))};
  }
  template <class Use>
  MOTES_INLINE void each(Floats3 p, const Use& use) const {
    const Floats height = dot(p - all3(point), all3(normal));
    use(0, Foot{~Mask{}, abs(height), all3(normal) * select(height < 0.0f, all(1.0f), all(-1.0f))});
  }
};

/// A triangle or a parallelogram.
struct FlatFeet {
  Float3 corner[4], normal;
  int corners;

  static MOTES_INLINE FlatFeet from(const shapes::Shape& s) {
    const auto plus = [](Float3 a, Float3 b) { return Float3{a.x + b.x, a.y + b.y, a.z + b.z}; };
    if (s.kind == shapes::Kind::triangle) {
      const auto triangle = s.as<shapes::numbers::triangle>();
      const Float3 p0 = of(triangle.p0), p1 = of(triangle.p1), p2 = of(triangle.p2);
      return {{p0, p1, p2, {}}, unit(cross(minus(p1, p0), minus(p2, p0))), 3};
    }
    const auto rectangle = s.as<shapes::numbers::rectangle>();
    const Float3 origin = of(rectangle.origin), u = of(rectangle.u), v = of(rectangle.v);
    return {{origin, plus(origin, u), plus(plus(origin, u), v), plus(origin, v)}, unit(cross(u, v)), 4};
  }
  template <class Use>
  MOTES_INLINE void each(Floats3 p, const Use& use) const {
    Mask within = ~Mask{};
    Floats nearest = all(__builtin_inff());
    Floats3 way{};
    for (int k = 0; k < corners; ++k) {
      const Float3 edge = minus(corner[k + 1 == corners ? 0 : k + 1], corner[k]);
      const Floats3 d = p - all3(corner[k]);
      within &= dot(d, all3(cross(normal, edge))) >= 0.0f;
      const Floats part = min(max(dot(d, all3(edge)) * (1.0f / dot(edge, edge)), Floats{}), all(1.0f));
      const Floats3 there = all3(edge) * part - d;
      const Floats distance2 = dot(there, there);
      const Mask nearer = distance2 < nearest;
      nearest = select(nearer, distance2, nearest);
      way = select(nearer, there, way);
    }
    const Floats height = dot(p - all3(corner[0]), all3(normal));
    use(0, foot_at(~Mask{}, select(within, all3(normal) * -height, way), all3(normal) * -1.0f));
  }
};

struct DiscFeet {
  Float3 center, normal, aside;
  float radius, inner;

  static MOTES_INLINE DiscFeet from(const shapes::Shape& s) {
    const auto disc = s.as<shapes::numbers::disc>();
    const Float3 normal = unit(of(disc.normal));
    return {of(disc.center), normal, basis_of(normal).u, disc.radius, disc.inner_radius};
  }
  template <class Use>
  MOTES_INLINE void each(Floats3 p, const Use& use) const {
    const Floats3 d = p - all3(center);
    const Floats height = dot(d, all3(normal));
    const Foot out = foot_at(~Mask{}, d - all3(normal) * height, all3(aside));
    const Floats there = min(max(out.distance, all(inner)), all(radius));
    use(0, foot_at(~Mask{}, out.towards * (there - out.distance) - all3(normal) * height, all3(normal) * -1.0f));
  }
};

/// A sphere, from outside and from inside; both of its surfaces if it is a thick shell.
struct BallFeet {
  Float3 center;
  float radius, inner;

  static MOTES_INLINE BallFeet from(const shapes::Shape& s) {
    const auto sphere = s.as<shapes::numbers::sphere>();
    return {of(sphere.center), sphere.radius, sphere.inner_radius};
  }
  template <class Use>
  MOTES_INLINE void each(Floats3 p, const Use& use) const {
    const Foot out = foot_at(~Mask{}, p - all3(center), all3(Float3{1, 0, 0}));
    const auto surface = [&](int face, float at, Mask seen) __attribute__((always_inline)) {
      const Floats way = at - out.distance;
      use(face, Foot{seen, abs(way), out.towards * select(way < 0.0f, all(-1.0f), all(1.0f))});
    };
    const bool bored = inner > 0.0f && inner < radius;
    surface(0, radius, bored ? out.distance >= inner : ~Mask{});
    if (bored) surface(1, inner, out.distance <= radius);
  }
};

struct BoxFeet {
  Float3 low, high;

  static MOTES_INLINE BoxFeet from(const shapes::Shape& s) {
    const auto box = s.as<shapes::numbers::box>();
    return {of(box.low), of(box.high)};
  }
  template <class Use>
  MOTES_INLINE void each(Floats3 p, const Use& use) const {
    const Floats3 way = Floats3{min(max(p.x, all(low.x)), all(high.x)), min(max(p.y, all(low.y)), all(high.y)),
                                min(max(p.z, all(low.z)), all(high.z))} -
                        p;
    const Floats outside2 = dot(way, way);
    const Mask inside = outside2 == 0.0f;
    const auto face = [&](int number, Floats distance, Float3 towards)
                          __attribute__((always_inline)) { use(number, Foot{inside, distance, all3(towards)}); };
    face(0, p.x - low.x, {-1, 0, 0});
    face(1, high.x - p.x, {1, 0, 0});
    face(2, p.y - low.y, {0, -1, 0});
    face(3, high.y - p.y, {0, 1, 0});
    face(4, p.z - low.z, {0, 0, -1});
    face(5, high.z - p.z, {0, 0, 1});
    use(6, foot_at(~inside, way, all3(Float3{0, -1, 0})));
  }
};

/// A cylinder or a cone: a polygon rotated around the axis, or a line if the wall has no thickness.
struct TurnedFeet {
  struct Corner {
    float radius, height;
  };
  Float3 start, axis, aside;
  Corner corner[4];  // anticlockwise
  int corners;
  bool solid;  // the last edge is the axis

  static MOTES_INLINE TurnedFeet from(const shapes::Shape& s) {
    const auto axial = s.as<shapes::numbers::axial>();
    const Float3 start = of(axial.start), whole = minus(of(axial.end), start);
    const float length = __builtin_sqrtf(dot(whole, whole)), outer = axial.radius, inner = axial.inner_radius;
    const Float3 axis = unit(whole), aside = basis_of(axis).u;
    const bool cylinder = s.kind == shapes::Kind::cylinder, thin = inner == outer, solid = inner == 0.0f;
    if (thin) return {start, axis, aside, {{cylinder ? outer : 0.0f, 0}, {outer, length}, {}, {}}, 2, false};
    if (cylinder) {
      return {start, axis, aside, {{inner, 0}, {outer, 0}, {outer, length}, {inner, length}}, 4, solid};
    }
    return {start, axis, aside, {{0, 0}, {outer, length}, {inner, length}, {}}, 3, solid};
  }
  template <class Use>
  MOTES_INLINE void each(Floats3 p, const Use& use) const {
    const Floats3 d = p - all3(start);
    const Floats height = dot(d, all3(axis));
    const Foot out = foot_at(~Mask{}, d - all3(axis) * height, all3(aside));
    const auto in_space = [&](Floats along, Floats up)
                              __attribute__((always_inline)) { return out.towards * along + all3(axis) * up; };
    Mask inside = corners > 2 ? ~Mask{} : Mask{};
    Floats nearest = all(__builtin_inff()), along{}, up{};
    Floats depth[4];
    Corner outward[4];
    const int edges = corners > 2 ? corners : 1;
    for (int k = 0; k < edges; ++k) {
      const Corner &from = corner[k], &to = corner[k + 1 == corners ? 0 : k + 1];
      const float x = to.radius - from.radius, y = to.height - from.height;
      const float length2 = x * x + y * y, scale = 1.0f / __builtin_sqrtf(length2);
      outward[k] = {y * scale, -x * scale};
      const Floats dx = out.distance - from.radius, dy = height - from.height;
      depth[k] = -(dx * outward[k].radius + dy * outward[k].height);
      if (solid && k + 1 == edges) continue;
      inside &= depth[k] >= 0.0f;
      const Floats part = min(max((dx * x + dy * y) * (1.0f / length2), Floats{}), all(1.0f));
      const Floats to_x = part * x - dx, to_y = part * y - dy, distance2 = to_x * to_x + to_y * to_y;
      const Mask nearer = distance2 < nearest;
      nearest = select(nearer, distance2, nearest);
      along = select(nearer, to_x, along);
      up = select(nearer, to_y, up);
    }
    const auto wall = [&](int k) __attribute__((always_inline)) {
      return in_space(all(outward[k].radius), all(outward[k].height));
    };
    for (int k = 0; corners > 2 && k < (solid ? edges - 1 : edges); ++k) use(k, Foot{inside, depth[k], wall(k)});
    use(4, foot_at(~inside, in_space(along, up), wall(0)));
  }
};

/// A closed mesh, from outside and from inside, by its grid of distances. Beyond the grid, by the nearest place in it.
struct MeshFeet {
  MeshLanes mesh;
  Pose pose;

  template <class Use>
  MOTES_INLINE void each(Floats3 p, const Use& use) const {
    const Floats3 q = pose.to_body(p), border = mesh.into_grid(q);
    const Floats there = mesh.distance(border);
    const Mask outside = there > 0.0f;
    const Floats3 normal = mesh.normal_at(border, Floats3{}, outside);
    const Foot foot = foot_at(~Mask{}, border - normal * abs(there) - q, normal * -1.0f);
    use(0, Foot{foot.mask, foot.distance, pose.turn(foot.towards)});
  }
};

/// A mesh that deforms, at a fraction of the frame.
struct DeformingFeet {
  DeformingLanes mesh;
  Pose pose;
  float when;

  template <class Use>
  MOTES_INLINE void each(Floats3 p, const Use& use) const {
    const Floats3 q = pose.to_body(p), border = mesh.into_grids(q);
    const Floats there = mesh.distance(border, all(when));
    const Floats3 normal = mesh.normal(border, all(when), there > 0.0f, all3(Float3{0, 1, 0}));
    const Foot foot = foot_at(~Mask{}, border - normal * abs(there) - q, normal * -1.0f);
    use(0, Foot{foot.mask, foot.distance, pose.turn(foot.towards)});
  }
};

/// Calls use(feet) with the feet of a shape that has a surface. Callers pass unions part by part. `part`: time as a
/// fraction of the frame, for meshes that move.
template <class Use>
MOTES_INLINE void visit_feet(const shapes::Shape& shape, float part, const Use& use) {
  switch (shape.kind) {
    case shapes::Kind::plane: return use(PlaneFeet::from(shape));
    case shapes::Kind::rectangle:
    case shapes::Kind::triangle: return use(FlatFeet::from(shape));
    case shapes::Kind::disc: return use(DiscFeet::from(shape));
    case shapes::Kind::box: return use(BoxFeet::from(shape));
    case shapes::Kind::sphere: return use(BallFeet::from(shape));
    case shapes::Kind::cylinder:
    case shapes::Kind::cone: return use(TurnedFeet::from(shape));
    case shapes::Kind::mesh: {
      if (shape.deformation != nullptr) {
        return use(DeformingFeet{DeformingLanes::from(*shape.deformation), pose_at(shape.number, part), part});
      }
      const MeshLanes mesh = MeshLanes::from(shape);
      if (mesh.has_inside()) use(MeshFeet{mesh, pose_at(shape.number, part)});
      return;
    }
    case shapes::Kind::point:
    case shapes::Kind::line:
    case shapes::Kind::blob:
    case shapes::Kind::united: return;
  }
}

}  // namespace motes::MOTES_ISA
