// Crossings of a vector of rays with each kind of object. Surfaces are visible from both sides, but of a sphere only
// the outer one; discs, cylinders and cones may have holes.
//
// find() returns the nearest crossings, normals() the normals there: not of unit length, and to either side.
#pragma once

#include "image/raycast/cast_meshes.h"

namespace motes::MOTES_ISA {

MOTES_INLINE RayHit find_plane(const float* v, const Rays& rays, Floats near, Floats far) {
  const Floats3 normal = all3(v);
  const Floats distance = (v[3] - dot(normal, rays.from)) / dot(normal, rays.along);
  return {between(distance, near, far), distance, Ints{}};
}

MOTES_INLINE RayHit find_disc(const float* v, const Rays& rays, Floats near, Floats far) {
  RayHit crossing = find_plane(v, rays, near, far);
  const Floats3 offset = at(rays, crossing.distance) - all3(v + 4);
  const Floats square = dot(offset, offset);
  crossing.met &= (square <= v[7]) & (square >= v[8]);
  return crossing;
}

MOTES_INLINE RayHit find_rectangle(const float* v, const Rays& rays, Floats near, Floats far) {
  RayHit crossing = find_plane(v, rays, near, far);
  const Floats3 point = at(rays, crossing.distance);
  const Floats a = dot(point, all3(v + 4)) - v[7], b = dot(point, all3(v + 8)) - v[11];
  crossing.met &= (a >= 0.0f) & (a <= 1.0f) & (b >= 0.0f) & (b <= 1.0f);
  return crossing;
}

MOTES_INLINE RayHit find_triangle(const float* v, const Rays& rays, Floats near, Floats far) {
  const float corner[3][3] = {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}};
  const Floats3 normal = all3(v + 9);
  const Floats distance = dot(normal, all3(corner[0]) - rays.from) / dot(normal, rays.along);
  return {pass_through(corner, rays) & between(distance, near, far), distance, Ints{}};
}

// Uses the perpendicular from the centre to the ray, which is precise far away, too (Haines, Guenther, Akenine-Moeller
// 2019).
template <bool kFromEye>
MOTES_INLINE RayHit find_sphere(const float* v, const Rays& rays, Floats near, Floats far) {
  const Floats3 offset = rays.from - all3(v);
  const Floats a = dot(rays.along, rays.along);
  const Floats b = dot(offset, rays.along);
  const Floats3 aside = offset - rays.along * (b / a);
  const Floats left = v[3] - dot(aside, aside);
  const Floats c = kFromEye ? all(v[4]) : dot(offset, offset) - v[3];
  const Floats root = sqrt(max(left, Floats{}) * a);
  // Compute both roots without cancellation.
  const Mask ahead = b < 0.0f;
  const Floats q = select(ahead, root - b, -b - root);
  const Floats one = q / a, other = c / q;
  const Floats first = select(ahead, other, one), second = select(ahead, one, other);
  const Floats distance = select(first > near, first, second);
  return {(left >= 0.0f) & between(distance, near, far), distance, Ints{}};
}

// Finds the part of a ray that is between all three pairs of faces.
MOTES_INLINE RayHit find_box(const float* v, const Rays& rays, Floats near, Floats far) {
  const Floats inverse[3] = {1.0f / not_zero(rays.along.x), 1.0f / not_zero(rays.along.y),
                             1.0f / not_zero(rays.along.z)};
  const Floats from[3] = {rays.from.x, rays.from.y, rays.from.z};
  Floats enter = all(-__FLT_MAX__), leave = all(__FLT_MAX__);
  Ints enter_face{}, leave_face{};
  for (int axis = 0; axis < 3; ++axis) {
    const Floats low = (v[axis] - from[axis]) * inverse[axis], high = (v[axis + 3] - from[axis]) * inverse[axis];
    const Floats first = min(low, high), last = max(low, high);
    const Mask later = first > enter, sooner = last < leave;
    enter = select(later, first, enter);
    leave = select(sooner, last, leave);
    enter_face = (later & (axis + 1)) | (~later & enter_face);
    leave_face = (sooner & (axis + 1)) | (~sooner & leave_face);
  }
  const Mask outside = enter > near;
  const Floats distance = select(outside, enter, leave);
  return {(enter <= leave) & between(distance, near, far), distance, (outside & enter_face) | (~outside & leave_face)};
}

// Cylinders and cones: an outer wall, an inner wall for pipes, and flat ends between them; if both radii are equal,
// only the wall. Distances along rays count from where they pass the object, so precision does not depend on how far
// away it is.
class ShellRays {
 public:
  MOTES_INLINE ShellRays(const float* v, const Rays& rays, bool cone)
      : length_(v[6]), outer_(v[7]), inner_(v[8]), cone_(cone), axis_(all3(v + 3)) {
    start_ = dot(all3(v + 9) - rays.from, rays.along) / dot(rays.along, rays.along);
    const Floats3 from = at(rays, start_) - all3(v);
    height_ = dot(from, axis_);
    rise_ = dot(rays.along, axis_);
    across_ = from - axis_ * height_;
    aside_ = rays.along - axis_ * rise_;
  }

  MOTES_INLINE RayHit find(Floats near, Floats far) const {
    RayHit found{Mask{}, far, Ints{}};
    add_wall(outer_, 0, near, found);
    if (inner_ != outer_) {
      if (inner_ > 0) add_wall(inner_, 3, near, found);
      add_end(length_, 1, near, found);
      if (!cone_) add_end(0, 2, near, found);
    }
    return found;
  }

  MOTES_INLINE Floats3 normals(const RayHit& crossing) const {
    const Mask end = (crossing.face == 1) | (crossing.face == 2);
    if (!cone_) return select(end, axis_, across_ + aside_ * (crossing.distance - start_));
    const Floats distance = crossing.distance - start_;
    const Floats widening = select(crossing.face == 3, all(inner_ / length_), all(outer_ / length_));
    const Floats3 outward = across_ + aside_ * distance - axis_ * (widening * widening * (height_ + distance * rise_));
    return select(end, axis_, outward);
  }

 private:
  MOTES_INLINE static void keep(Mask met, Floats distance, int face, RayHit& found) {
    found.distance = select(met, distance, found.distance);
    found.face = (met & face) | (~met & found.face);
    found.met |= met;
  }

  // Adds the wall whose distance from the axis is `radius`: at any height of a cylinder, at the base of a cone.
  MOTES_INLINE void add_wall(float radius, int face, Floats near, RayHit& found) const {
    const float widening = cone_ ? radius / length_ : 0;
    const Floats here = cone_ ? widening * height_ : all(radius);
    const Floats change = widening * rise_;
    const Floats a = dot(aside_, aside_) - change * change;
    const Floats b = dot(across_, aside_) - here * change;
    const Floats c = dot(across_, across_) - here * here;
    const Floats discriminant = b * b - a * c;
    // Compute both roots without cancellation; along a cone's side a is 0 and one of them is infinite.
    const Floats root = sqrt(max(discriminant, Floats{}));
    const Floats q = select(b < 0.0f, root - b, -b - root);
    const Floats one = q / a, other = c / q;
    Mask open = discriminant >= 0.0f;
    for (const Floats from_start : {min(one, other), max(one, other)}) {
      const Floats distance = start_ + from_start;
      const Floats height = height_ + from_start * rise_;
      const Mask met = open & between(distance, near, found.distance) & (height >= 0.0f) & (height <= length_);
      keep(met, distance, face, found);
      open &= ~met;
    }
  }

  // Adds the flat end at a height, a ring.
  MOTES_INLINE void add_end(float height, int face, Floats near, RayHit& found) const {
    const Floats from_start = (height - height_) / rise_;
    const Floats distance = start_ + from_start;
    const Floats3 offset = across_ + aside_ * from_start;
    const Floats square = dot(offset, offset);
    keep(between(distance, near, found.distance) & (square <= outer_ * outer_) & (square >= inner_ * inner_), distance,
         face, found);
  }

  float length_, outer_, inner_;
  bool cone_;
  Floats3 axis_;
  Floats start_, height_, rise_;
  Floats3 across_, aside_;
};

template <bool kFromEye>
MOTES_INLINE RayHit find(const image::CastSolid& solid, const Rays& rays, Floats near, Floats far) {
  using shapes::Kind;
  const float* v = solid.value;
  if (solid.nodes != nullptr) return MeshRays(solid, rays).nearest(near, far);
  switch (solid.kind) {
    case Kind::plane: return find_plane(v, rays, near, far);
    case Kind::disc: return find_disc(v, rays, near, far);
    case Kind::rectangle: return find_rectangle(v, rays, near, far);
    case Kind::triangle: return find_triangle(v, rays, near, far);
    case Kind::box: return find_box(v, rays, near, far);
    case Kind::sphere: return find_sphere<kFromEye>(v, rays, near, far);
    case Kind::cylinder: return ShellRays(v, rays, false).find(near, far);
    case Kind::cone: return ShellRays(v, rays, true).find(near, far);
    // Refused by check_solid().
    case Kind::point:
    case Kind::line:
    case Kind::blob:
    case Kind::united:
    case Kind::mesh: break;
  }
  return {Mask{}, far, Ints{}};
}

/// Returns which rays meet the object between `near` and `far`. Only the lanes of `open` matter.
MOTES_INLINE Mask blocked(const image::CastSolid& solid, const Rays& rays, Floats near, Floats far, Mask open) {
  if (solid.nodes != nullptr) return MeshRays(solid, rays).blocked(near, far, open);
  return find<false>(solid, rays, near, far).met;
}

MOTES_INLINE Floats3 normals(const image::CastSolid& solid, const Rays& rays, const RayHit& crossing) {
  using shapes::Kind;
  const float* v = solid.value;
  if (solid.nodes != nullptr) return out_of_mesh(solid, mesh_normals(solid.triangles, crossing));
  switch (solid.kind) {
    case Kind::plane:
    case Kind::disc:
    case Kind::rectangle: return all3(v);
    case Kind::triangle: return all3(v + 9);
    case Kind::box: {
      const Floats one = all(1);
      return {only(crossing.face == 1, one), only(crossing.face == 2, one), only(crossing.face == 3, one)};
    }
    case Kind::cylinder: return ShellRays(v, rays, false).normals(crossing);
    case Kind::cone: return ShellRays(v, rays, true).normals(crossing);
    case Kind::sphere:
    case Kind::point:
    case Kind::line:
    case Kind::blob:
    case Kind::united:
    case Kind::mesh: break;
  }
  return at(rays, crossing.distance) - all3(v);  // of a sphere
}

}  // namespace motes::MOTES_ISA
