// bounce off a mesh that may move: paths are followed in the mesh's own coordinates, from its pose at the start of the
// step to its pose at the end, so neither a fast particle nor a fast mesh passes through the other. Velocities are
// reflected relative to the surface, whose own velocity is added:
//   v' = u + bounce(v - u), u = the velocity of the surface at the hit
// A particle's side is the sign that the mesh's grid gives for its position, to the last bit; it never changes.
#pragma once

#include "actions/bounce.h"
#include "shapes/mesh.h"

namespace motes::MOTES_ISA {

/// A mesh during a step.
struct MovingMesh {
  MeshLanes mesh;
  Pose start, end;
  bool moves;

  static MOTES_INLINE MovingMesh from(const shapes::Shape& s, const actions::Step& step) {
    bool moves = false;
    for (int i = 0; i < 7; ++i) moves |= s.number[i] != s.number[7 + i];
    return {MeshLanes::from(s), pose_at(s.number, step.start), pose_at(s.number, step.end), moves};
  }
  /// Converts to world coordinates at a fraction of the step, one per lane.
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
  /// Returns false where a path stays clear of the mesh. Judged in the mesh's coordinates, in which it is at rest and
  /// paths are straight.
  MOTES_INLINE Mask may_meet(Floats3 from, Floats3 to) const {
    return mesh.may_meet_in_body(start.to_body(from), end.to_body(to));
  }
  /// Returns the velocity of the surface at q, m/s.
  MOTES_INLINE Floats3 velocity(Floats3 q, float dt) const {
    return moves ? (end.to_world(q) - start.to_world(q)) * (1.0f / dt) : Floats3{};
  }
};

/// Returns the next hit of each path for the lanes of `among`, in the mesh's coordinates.
MOTES_INLINE Hit meet(const MeshLanes& mesh, Floats3 from, Floats3 to, Floats start, Mask outside, Mask among) {
  const Passage passage = mesh.follow(from, to, start, outside, among);
  if (!any(passage.mask)) return {passage.mask, passage.part, Floats3{}};
  const Floats3 way = to - from;
  return {passage.mask, passage.part, mesh.normal_at(from + way * passage.part, way, outside)};
}

/// Stops the particles caught in a corner (the lanes of `caught`), so that the move ends on their side of the surface
/// at `from`. Tries growing distances from the surface, later with the surface's own velocity; failing that, the
/// particles stay where they started.
__attribute__((noinline)) inline void stop(const MovingMesh& moving, float dt, Mask caught, Mask outside, Floats skin,
                                           Floats3 from, Floats3& x, Floats3& v) {
  const Floats3 start = x, still = moving.velocity(from, dt);
  for (int tries = 0;; ++tries) {
    from = moving.mesh.on_side(from, outside, skin);
    x = select(caught, moving.to_world(from, all(1.0f)) - v * dt, x);
    caught &= (moving.mesh.distance(moving.end.to_body(x + v * dt)) > 0.0f) ^ outside;
    if (!any(caught)) return;
    if (tries == 8) break;
    skin = skin * 2.0f;
    from = select(caught, from + moving.mesh.normal_at(from, Floats3{}, outside) * skin, from);
    if (tries == 4) v = select(caught, still, v);
  }
  x = select(caught, start, x);
  v = select(caught, still, v);
}

/// Sets positions and velocities of the lanes of `going` so that the move that follows ends where their paths end;
/// returns which bounced.
MOTES_INLINE Mask bounce_off(const MovingMesh& moving, const Rebound& rebound, float dt, Mask going, Floats3& x,
                             Floats3& v) {
  const MeshLanes& mesh = moving.mesh;
  const Floats3 begin = x;
  Floats3 from = moving.start.to_body(x);
  Floats start = mesh.distance(from);
  const Mask outside = start > 0.0f;
  const Floats skin = skin_of(x, x + v * dt, v * dt) + 1e-4f * mesh.form->cell;
  Floats passed{};  // fraction of the step before the last hit
  Mask bounced{};
  for (int hits = 1;; ++hits) {
    const Floats3 to = moving.end.to_body(x + v * dt);  // where the move would end
    const Hit hit = meet(mesh, from, to, start, outside, going);
    if (!any(hit.mask)) return bounced;
    bounced |= hit.mask;
    going = hit.mask;
    from = select(hit.mask, from + (to - from) * hit.part + hit.normal * skin, from);
    passed = select(hit.mask, passed + (1.0f - passed) * hit.part, passed);
    const Floats3 surface = moving.velocity(from, dt);
    const Floats3 after = rebound(v - surface, moving.turn(hit.normal, passed)) + surface;
    v = select(hit.mask, after, v);
    if (hits == kMostHits) {
      x = select(hit.mask, begin, x);
      stop(moving, dt, hit.mask, outside, skin, from, x, v);
      return bounced;
    }
    x = select(hit.mask, moving.to_world(from, passed) - v * (passed * dt), x);
    start = mesh.distance(from);
  }
}

inline void bounce_off_mesh(const shapes::Shape& shape, const Rebound& rebound, const actions::Block& b,
                            const actions::Step& s) {
  const MovingMesh moving = MovingMesh::from(shape, s);
  if (!moving.mesh.has_inside()) return;
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    Floats3 x = load3(b, kPositionAt, i), v = load3(b, kVelocityAt, i);
    const Mask near = moving.may_meet(x, x + v * s.dt);
    if (!any(near)) continue;
    const Floats3 x0 = x, v0 = v;
    const Mask bounced = bounce_off(moving, rebound, s.dt, near, x, v);
    if (!any(bounced)) continue;
    store3(b, kPositionAt, i, select(bounced, x, x0));
    store3(b, kVelocityAt, i, select(bounced, v, v0));
    note_hit(b, i, bounced);
  }
}

}  // namespace motes::MOTES_ISA
