// bounce off a mesh that may move and deform: paths are followed in the mesh's own coordinates, from its pose at the
// start of the step to its pose at the end, so neither a fast particle nor a fast mesh passes through the other. A mesh
// that deforms also changes along the path (shapes/deforming.h). Velocities are reflected relative to the surface,
// whose own velocity is added:
//   v' = u + bounce(v - u), u = the velocity of the surface at the hit
// A particle's side is the sign that the mesh's grid gives for its position, to the last bit; it never changes.
#pragma once

#include "actions/bounce.h"
#include "shapes/deforming.h"
#include "shapes/mesh.h"

namespace motes::MOTES_ISA {

/// The pose of a mesh during a step. `part`: the fraction of the step that has passed, one per lane.
struct MovingPose {
  Pose start, end;
  bool moves;

  static MOTES_INLINE MovingPose from(const shapes::Shape& s, const actions::Step& step) {
    return {pose_at(s.number, step.start), pose_at(s.number, step.end), shapes::changes_place(s)};
  }
  MOTES_INLINE Floats3 to_world(Floats3 q, Floats part) const {
    const Floats3 later = end.to_world(q);
    if (!moves) return later;
    const Floats3 earlier = start.to_world(q);
    return earlier + (later - earlier) * part;
  }
  MOTES_INLINE Floats3 turn(Floats3 normal, Floats part) const {
    const Floats3 later = end.turn(normal);
    if (!moves) return later;
    const Floats3 earlier = start.turn(normal);
    const Floats3 between = earlier + (later - earlier) * part;
    return between * (1.0f / sqrt(max(dot(between, between), all(1e-30f))));
  }
  MOTES_INLINE Floats3 turn_freely(Floats3 vector, Floats part) const {
    const Floats3 earlier = start.turn(vector);
    return earlier + (end.turn(vector) - earlier) * part;
  }
  /// Returns the velocity of the point q of the body, m/s.
  MOTES_INLINE Floats3 velocity(Floats3 q, float dt) const {
    return moves ? (end.to_world(q) - start.to_world(q)) * (1.0f / dt) : Floats3{};
  }
};

// The two classes below tell bounce_off() about a mesh during a step. Places are in the mesh's coordinates, in which
// paths are straight; `part` is the fraction of the step that has passed.

/// A rigid mesh.
struct RigidMesh {
  MeshLanes mesh;
  MovingPose pose;

  static MOTES_INLINE RigidMesh from(const shapes::Shape& s, const actions::Step& step) {
    return {MeshLanes::from(s), MovingPose::from(s, step)};
  }
  MOTES_INLINE Mask may_meet(Floats3 from, Floats3 to) const { return mesh.may_meet_in_body(from, to); }
  MOTES_INLINE Floats distance(Floats3 q, Floats /*part*/) const { return mesh.distance(q); }
  MOTES_INLINE Hit next(Floats3 from, Floats3 to, Floats /*part*/, Floats start, Mask outside, Mask among) const {
    const Passage passage = mesh.follow(from, to, start, outside, among);
    if (!any(passage.mask)) return {passage.mask, passage.part, Floats3{}};
    const Floats3 way = to - from;
    return {passage.mask, passage.part, mesh.normal_at(from + way * passage.part, way, outside)};
  }
  MOTES_INLINE Floats3 normal_at_end(Floats3 q, Mask outside) const { return mesh.normal_at(q, Floats3{}, outside); }
  MOTES_INLINE Floats3 carried_to_end(Floats3 q, Floats /*part*/, Mask /*outside*/, Floats /*skin*/) const { return q; }
  MOTES_INLINE Floats3 velocity(Floats3 q, Floats /*part*/, float dt) const { return pose.velocity(q, dt); }
};

/// A mesh that deforms.
struct DeformingMesh {
  DeformingLanes mesh;
  MovingPose pose;
  float begin, span;  // of the step, as fractions of the frame

  static MOTES_INLINE DeformingMesh from(const shapes::Shape& s, const actions::Step& step) {
    return {DeformingLanes::from(*s.deformation), MovingPose::from(s, step), step.start, step.end - step.start};
  }
  static MOTES_INLINE Floats3 up() { return {all(0.0f), all(1.0f), all(0.0f)}; }
  MOTES_INLINE Floats when(Floats part) const { return select(part == 1.0f, all(begin + span), begin + span * part); }
  MOTES_INLINE Mask may_meet(Floats3 from, Floats3 to) const { return mesh.may_meet(from, to); }
  MOTES_INLINE Floats distance(Floats3 q, Floats part) const { return mesh.distance(q, when(part)); }
  MOTES_INLINE Hit next(Floats3 from, Floats3 to, Floats part, Floats start, Mask outside, Mask among) const {
    const Passage passage = mesh.follow(from, to, when(part), begin + span, start, outside, among);
    if (!any(passage.mask)) return {passage.mask, passage.part, Floats3{}};
    const Floats3 way = to - from, there = from + way * passage.part;
    const Floats then = when(part + (1.0f - part) * passage.part);
    return {passage.mask, passage.part, mesh.normal(there, then, outside, up())};
  }
  MOTES_INLINE Floats3 normal_at_end(Floats3 q, Mask outside) const {
    return mesh.normal(q, all(begin + span), outside, up());
  }
  /// Returns where the surface carries the place q until the step ends. In small steps, each of which ends on the side
  /// given by `outside`: the error of a single one could exceed the thickness of a sheet.
  Floats3 carried_to_end(Floats3 q, Floats part, Mask outside, Floats skin) const {
    constexpr int kSteps = 16;
    Floats now = when(part);
    for (int k = 1; k <= kSteps; ++k) {
      const Floats next =
          k == kSteps ? all(begin + span) : when(part + (1.0f - part) * (static_cast<float>(k) / kSteps));
      q = q + mesh.motion(q, now) * (next - now);
      const Floats there = mesh.distance(q, next);
      const Mask wrong = (there > 0.0f) ^ outside;
      q = select(wrong, q + mesh.normal(q, next, outside, up()) * (abs(there) * 1.25f + skin), q);
      now = next;
    }
    return q;
  }
  MOTES_INLINE Floats3 velocity(Floats3 q, Floats part, float dt) const {
    return pose.velocity(q, dt) + pose.turn_freely(mesh.motion(q, when(part)), part) * (span / dt);
  }
};

/// Stops the particles caught in a corner (the lanes of `caught`), so that the move ends on their side of the surface
/// at `from`. Tries growing distances from the surface, later with the surface's own velocity; failing that, the
/// particles stay where they started.
template <class Moving>
__attribute__((noinline)) void stop(const Moving& moving, float dt, Mask caught, Mask outside, Floats skin,
                                    Floats3 from, Floats3& x, Floats3& v) {
  const Floats last = all(1.0f);
  const Floats3 start = x, still = moving.velocity(from, last, dt);
  for (int tries = 0;; ++tries) {
    for (int i = 0; i < 4; ++i) {  // onto their side
      const Floats there = moving.distance(from, last);
      const Mask wrong = (there > 0.0f) ^ outside;
      if (!any(wrong)) break;
      from = select(wrong, from + moving.normal_at_end(from, outside) * (abs(there) * 1.25f + skin), from);
    }
    x = select(caught, moving.pose.to_world(from, last) - v * dt, x);
    caught &= (moving.distance(moving.pose.end.to_body(x + v * dt), last) > 0.0f) ^ outside;
    if (!any(caught)) return;
    if (tries == 8) break;
    skin = skin * 2.0f;
    from = select(caught, from + moving.normal_at_end(from, outside) * skin, from);
    if (tries == 4) v = select(caught, still, v);
  }
  x = select(caught, start, x);
  v = select(caught, still, v);
}

/// Adds hits of the lanes of `mask`, at the place `from` of the body. A particle does not land on a surface that moves,
/// nor where rounding puts its place on the other side.
template <class Moving>
MOTES_INLINE void note_on(const Moving& moving, Hits& seen, Mask mask, Mask outside, Floats3 from, Floats passed,
                          Floats3 normal, Floats3 surface) {
  const Floats3 place = moving.pose.to_world(from, passed);
  const Mask still = (surface.x == 0.0f) & (surface.y == 0.0f) & (surface.z == 0.0f);
  const Mask right = ~((moving.distance(moving.pose.end.to_body(place), all(1.0f)) > 0.0f) ^ outside);
  seen.count = seen.count + only(mask, all(1.0f));
  seen.normal = select(mask, normal, seen.normal);
  seen.place = select(mask, place, seen.place);
  seen.still = select(mask, still & right, seen.still);
}

/// Sets positions and velocities of the lanes of `going` so that the move that follows ends where their paths end;
/// returns which bounced. `seen`: where their hits are noted; may be null.
template <class Moving>
MOTES_INLINE Mask bounce_off(const Moving& moving, float cell, const Rebound& rebound, float dt, Mask going, Floats3& x,
                             Floats3& v, Hits* seen) {
  const Floats3 begin = x;
  Floats passed{};  // fraction of the step before the last hit
  Floats3 from = moving.pose.start.to_body(x);
  Floats start = moving.distance(from, passed);
  const Mask outside = start > 0.0f;
  const Floats skin = skin_of(x, x + v * dt, v * dt) + 1e-4f * cell;
  Mask bounced{};
  for (int hits = 1;; ++hits) {
    const Floats3 to = moving.pose.end.to_body(x + v * dt);  // where the move would end
    const Hit hit = moving.next(from, to, passed, start, outside, going);
    if (!any(hit.mask)) return bounced;
    bounced |= hit.mask;
    going = hit.mask;
    from = select(hit.mask, from + (to - from) * hit.part + hit.normal * skin, from);
    passed = select(hit.mask, passed + (1.0f - passed) * hit.part, passed);
    const Floats3 surface = moving.velocity(from, passed, dt);
    const Floats3 normal = moving.pose.turn(hit.normal, passed);
    const Floats3 after = rebound(v - surface, normal) + surface;
    v = select(hit.mask, after, v);
    if (seen != nullptr) note_on(moving, *seen, hit.mask, outside, from, passed, normal, surface);
    if (hits == kMostHits) {
      x = select(hit.mask, begin, x);
      stop(moving, dt, hit.mask, outside, skin, moving.carried_to_end(from, passed, outside, skin), x, v);
      return bounced;
    }
    x = select(hit.mask, moving.pose.to_world(from, passed) - v * (passed * dt), x);
    start = moving.distance(from, passed);
  }
}

template <class Moving>
MOTES_INLINE void bounce_block(const Moving& moving, float cell, const Rebound& rebound, const actions::Block& b,
                               float dt) {
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    Floats3 x = load3(b, kPositionAt, i), v = load3(b, kVelocityAt, i);
    const Mask near = moving.may_meet(moving.pose.start.to_body(x), moving.pose.end.to_body(x + v * dt));
    if (!any(near)) continue;
    const Floats3 x0 = x, v0 = v;
    Hits hits{};
    const Mask bounced = bounce_off(moving, cell, rebound, dt, near, x, v, b.stamp != 0 ? &hits : nullptr);
    if (!any(bounced)) continue;
    if (b.stamp != 0) note_hits(b, i, bounced, hits, x0);
    store3(b, kPositionAt, i, select(bounced, x, x0));
    store3(b, kVelocityAt, i, select(bounced, v, v0));
    note_hit(b, i, bounced);
  }
}

inline void bounce_off_mesh(const shapes::Shape& shape, const Rebound& rebound, const actions::Block& b,
                            const actions::Step& s) {
  if (shape.form == nullptr || shape.form->distance == nullptr) return;
  if (shape.deformation == nullptr) {
    bounce_block(RigidMesh::from(shape, s), shape.form->cell, rebound, b, s.dt);
  } else {
    bounce_block(DeformingMesh::from(shape, s), shape.form->cell, rebound, b, s.dt);
  }
}

}  // namespace motes::MOTES_ISA
