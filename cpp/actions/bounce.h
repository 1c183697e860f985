// bounce: reflects particles whose path in this step meets the shape's surface.
//
// With n the normal at the exact point of the hit, v splits into v_n along n and v_t along the surface:
//   v' = (1 - friction) v_t - restitution v_n        (no friction where |v_t| <= min_tangential_speed)
// The rest of the step continues from the hit with v' and may hit again, as in corners or inside a sphere. Since the
// move that follows covers the whole step at the final velocity, the position is set to where that move must start.
// Particles stay on their side of the surface; bounce_path.h states the invariant and the rounding error.
//
// Without exact_hit it works like McAllister's Bounce: only v changes, if the predicted position x + v dt is beyond the
// surface, and again if v' still leads beyond it, as in a corner. Planes then have two sides, and a sphere's n is taken
// at the old position.
#pragma once

#include <type_traits>

#include "actions/bounce_path.h"

namespace motes::MOTES_ISA {

/// `path`: the step's displacement.
MOTES_INLINE Floats skin_of(Floats3 start, Floats3 end, Floats3 path) {
  return max(max(largest(start), largest(end)), largest(path) * 0.25f) * 0x1p-20f;
}

MOTES_INLINE void note_hit(const actions::Block& b, std::size_t i, Mask mask) {
  if (b.hit != nullptr) store_mask(b.hit + i, load_mask(b.hit + i) | mask);
}

/// Bounces the particles of a vector that may meet the shape: the lanes of `near`. Seen: HalfHits or Unseen.
template <class Seen>
__attribute__((noinline)) void bounce_near(const shapes::Shape& shape, const Rebound& rebound, const actions::Block& b,
                                           float dt, std::size_t i, const Mask& near) {
  Floats3 x = load3(b, kPositionAt, i), v = load3(b, kVelocityAt, i);
  const Floats3 start = x;
  Seen hits[2];
  const Mask bounced = by_halves(near & finite(x + v * dt), x, v, [&](Longs lanes, Doubles3& p, Doubles3& w, int half) {
    return follow(shape, rebound, dt, lanes, p, w, hits[half]);
  });
  if (!any(bounced)) return;
  if constexpr (std::is_same_v<Seen, HalfHits>) note_hits(b, i, bounced, join(hits[0], hits[1]), start);
  store3(b, kPositionAt, i, x);
  store3(b, kVelocityAt, i, v);
  note_hit(b, i, bounced);
}

MOTES_INLINE void bounce_near(const shapes::Shape& shape, const Rebound& rebound, const actions::Block& b, float dt,
                              std::size_t i, const Mask& near) {
  const auto bounce = b.stamp != 0 ? bounce_near<HalfHits> : bounce_near<Unseen>;
  bounce(shape, rebound, b, dt, i, near);
}

template <class Lanes>
MOTES_INLINE void bounce_exactly(const Lanes& lanes, const shapes::Shape& shape, const Rebound& rebound,
                                 const actions::Block& b, float dt) {
  if constexpr (requires(Floats3 p) { lanes.may_meet(p, p); }) {
    const auto test = [&](std::size_t i) __attribute__((always_inline)) {
      const Floats3 x = load3(b, kPositionAt, i);
      const Mask near = lanes.may_meet(x, x + load3(b, kVelocityAt, i) * dt);
      if (any(near)) bounce_near(shape, rebound, b, dt, i, near);  // rarely
    };
    if constexpr (requires { lanes.clear(); }) {
      const auto clear = lanes.clear();
      const auto near = [&](std::size_t i) __attribute__((always_inline)) {
        return clear.may_meet(load3(b, kPositionAt, i), load3(b, kVelocityAt, i), dt);
      };
      where_any(b.count, near, test);
    } else {
      for (std::size_t i = 0; i < b.count; i += kLanes) test(i);
    }
  }
}

/// Returns the axis along which a normal is 1 or -1, or -1 if the normal is oblique.
MOTES_INLINE int axis_of(Float3 normal) {
  const auto one = [](float along) { return along == 1 || along == -1; };
  if (normal.y == 0 && normal.z == 0 && one(normal.x)) return 0;
  if (normal.x == 0 && normal.z == 0 && one(normal.y)) return 1;
  return normal.x == 0 && normal.y == 0 && one(normal.z) ? 2 : -1;
}

/// A plane whose normal is kSide (1 or -1) along an axis, usually the ground. One coordinate decides the side, and only
/// friction changes velocities along the other axes, so single precision is enough.
template <int kSide>
class UprightPlane {
 public:
  UprightPlane(int axis, float point, const Rebound& rebound, const actions::Block& b, float dt)
      : axis_(axis), point_(point), dt_(dt), rebound_(rebound) {
    for (int c = 0; c < 3; ++c) {
      x_[c] = b.component[kPositionAt + (axis + c) % 3];
      v_[c] = b.component[kVelocityAt + (axis + c) % 3];
    }
  }

  /// Returns which particles may end beyond the plane, from two columns only.
  MOTES_INLINE Mask met(std::size_t i) const {
    const Floats change = load(v_[0] + i) * dt_;
    return below(load(x_[0] + i) + change) & falls(change);
  }

  /// Where particles were before the step and at the hit; the first component is along the plane's axis.
  struct Way {
    Floats3 start, place;
  };

  /// Bounces the particles that met() selects and returns which; sets `sunk` where rounding would still let the move
  /// end below, and `way` if kNotes.
  template <bool kNotes>
  MOTES_INLINE Mask turn(std::size_t i, Mask& sunk, Way& way) const {
    const Floats3 x = load_turned(x_, i), v = load_turned(v_, i);
    const Floats before = to_side(x.x - point_), down = to_side(v.x * dt_);
    const Floats part = min(max(before / -down, Floats{}), all(1.0f));
    const Floats passed = part * dt_;
    const Mask mask = met(i) & finite({abs(x.y) + abs(x.z), v.y, v.z});  // as for oblique planes
    const Floats slide = rebound_.kept(v.y * v.y + v.z * v.z);
    // Adding 0 turns -0 into 0.
    const Floats3 after = {Floats{} - v.x * rebound_.restitution, v.y * slide + 0.0f, v.z * slide + 0.0f};
    const Floats skin = to_side(skin_of(x, x + v * all(dt_) * part, v * all(dt_)));
    Floats3 there = x + (v - after) * passed;
    there.x = there.x + skin;
    if constexpr (kNotes) way = {x, {x.x + v.x * passed + skin, x.y + v.y * passed, x.z + v.z * passed}};
    sunk = mask & below(there.x + after.x * dt_) & ~below(x.x);
    const Mask kept = mask & ~sunk;
    store_turned(x_, i, select(kept, there, x));
    store_turned(v_, i, select(kept, after, v));
    return kept;
  }

  /// Notes hits in the columns of the lanes of `mask`.
  MOTES_INLINE void note(const actions::Block& b, std::size_t i, Mask mask, const Way& way) const {
    const Floats3 normal = {all(kSide), Floats{}, Floats{}};
    note_hits(b, i, mask, {all(1.0f), in_world(normal), in_world(way.place), ~Mask{}}, in_world(way.start));
  }

 private:
  static MOTES_INLINE Mask falls(Floats change) { return kSide > 0 ? change < 0.0f : change > 0.0f; }
  MOTES_INLINE Mask below(Floats along) const { return kSide > 0 ? along <= point_ : along >= point_; }
  static MOTES_INLINE Floats to_side(Floats along) { return kSide > 0 ? along : -along; }

  MOTES_INLINE Floats3 in_world(Floats3 p) const {
    return axis_ == 0 ? p : axis_ == 1 ? Floats3{p.z, p.x, p.y} : Floats3{p.y, p.z, p.x};
  }

  // Load and store vectors whose first component is along the plane's axis.
  static MOTES_INLINE Floats3 load_turned(float* const* from, std::size_t i) {
    return {load(from[0] + i), load(from[1] + i), load(from[2] + i)};
  }
  static MOTES_INLINE void store_turned(float* const* to, std::size_t i, Floats3 p) {
    store(to[0] + i, p.x);
    store(to[1] + i, p.y);
    store(to[2] + i, p.z);
  }

  int axis_;
  float point_, dt_;
  Rebound rebound_;
  float *x_[3], *v_[3];
};

template <bool kNotes, int kSide>
MOTES_INLINE void bounce_off(const UprightPlane<kSide>& plane, const shapes::Shape& shape, const Rebound& rebound,
                             const actions::Block& b, float dt) {
  where_any(
      b.count, [&](std::size_t i) __attribute__((always_inline)) { return plane.met(i); },
      [&](std::size_t i) __attribute__((always_inline)) {
        Mask sunk;
        typename UprightPlane<kSide>::Way way;
        const Mask bounced = plane.template turn<kNotes>(i, sunk, way);
        note_hit(b, i, bounced);
        if constexpr (kNotes) plane.note(b, i, bounced, way);
        if (any(sunk)) bounce_near(shape, rebound, b, dt, i, sunk);
      });
}

MOTES_INLINE void bounce_exactly(const PlaneLanes& plane, const shapes::Shape& shape, const Rebound& rebound,
                                 const actions::Block& b, float dt) {
  const Float3 point = plane.point, normal = plane.normal;
  const int axis = axis_of(normal);
  if (axis < 0) return bounce_exactly<PlaneLanes>(plane, shape, rebound, b, dt);
  const float at = axis == 0 ? point.x : axis == 1 ? point.y : point.z;
  const auto off = [&](const auto& upright) __attribute__((always_inline)) {
    if (b.stamp != 0) return bounce_off<true>(upright, shape, rebound, b, dt);
    bounce_off<false>(upright, shape, rebound, b, dt);
  };
  if (normal.x + normal.y + normal.z > 0) return off(UprightPlane<1>(axis, at, rebound, b, dt));
  off(UprightPlane<-1>(axis, at, rebound, b, dt));
}

/// Reflects velocities if the predicted positions are beyond the surface; returns which particles bounced.
template <class Shape>
MOTES_INLINE Mask turn_back(const Shape& shape, const Rebound& rebound, Floats3 x, Floats3& v, float dt) {
  const Hit hit = shape.hit(x, v * all(dt));
  v = select(hit.mask, rebound(v, hit.normal), v);
  return hit.mask;
}

MOTES_INLINE Mask turn_back(const PlaneLanes& plane, const Rebound& rebound, Floats3 x, Floats3& v, float dt) {
  const PlaneCrossing crossing = cross_plane(plane.point, plane.normal, x, v * all(dt));
  v = select(crossing.mask, rebound(v, crossing.normal), v);
  return crossing.mask;
}

MOTES_INLINE Mask turn_back(const SphereLanes& sphere, const Rebound& rebound, Floats3 x, Floats3& v, float dt) {
  const float radius2 = sphere.radius * sphere.radius;
  const Floats3 d = x - all3(sphere.center);
  const Floats distance2 = dot(d, d);
  const Floats3 next = d + v * dt;
  const Mask inside = distance2 <= radius2;
  const Mask mask = inside ^ (dot(next, next) <= radius2);
  const Floats3 normal = d * (all(1.0f) / sqrt(max(distance2, all(__FLT_MIN__))));
  Floats3 after = rebound(v, normal);
  // A particle inside must move inwards. If it already did, by the normal at its old position, the rebound turned it
  // out.
  const Floats outwards = max(dot(after, normal), Floats{});
  after = select(inside, after - normal * (outwards + outwards), after);
  // A particle that would still leave ends the step just below the surface.
  const Floats3 there = d + after * dt;
  const Floats there2 = dot(there, there);
  const Floats3 just_inside = there * (0.999f * sphere.radius / sqrt(max(there2, all(__FLT_MIN__))));
  after = select(inside & (there2 > radius2), (just_inside - d) * (1.0f / dt), after);
  v = select(mask, after, v);
  return mask;
}

/// Defined in bounce_mesh.h.
inline void bounce_off_mesh(const shapes::Shape& shape, const Rebound& rebound, const actions::Block& b,
                            const actions::Step& s);

/// Returns false where a path certainly stays on its side.
template <class Lanes>
MOTES_INLINE Mask may_turn(const Lanes& lanes, Floats3 x, Floats3 to) {
  if constexpr (requires { lanes.may_pass(x, to); }) return lanes.may_pass(x, to);
  if constexpr (requires { lanes.may_meet(x, to); }) return lanes.may_meet(x, to);
  return Mask{};
}

/// Turns those particles of `near` that would still end on the other side, due to rounding, an edge or a round wall.
/// Returns which it turned.
__attribute__((noinline)) inline Mask turn_near(const shapes::Shape& shape, const Rebound& rebound, float dt,
                                                const Mask& near, const Floats3& at, Floats3& v) {
  Floats3 x = at;
  return by_halves(near, x, v,
                   [&](Longs among, Doubles3& p, Doubles3& w, int) { return turn(shape, rebound, dt, among, p, w); });
}

/// Bounces a vector of particles by changing only their velocities.
template <class Lanes>
MOTES_INLINE void turn_vector(const Lanes& lanes, const shapes::Shape& shape, const Rebound& rebound,
                              const actions::Block& b, float dt, std::size_t i) {
  const Floats3 x = load3(b, kPositionAt, i);
  Floats3 v = load3(b, kVelocityAt, i);
  Mask mask = turn_back(lanes, rebound, x, v, dt);
  const Floats3 to = x + v * dt;
  const Mask stands = (to.x == x.x) & (to.y == x.y) & (to.z == x.z);
  const Mask near = may_turn(lanes, x, to) & finite(to) & ~stands;
  if (any(near)) mask |= turn_near(shape, rebound, dt, near, x, v);  // rarely
  if (!any(mask)) return;
  store3(b, kVelocityAt, i, v);
  note_hit(b, i, mask);
}

inline void bounce(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::bounce>(p);
  const Rebound rebound{n.restitution, 1.0f - n.friction, n.min_tangential_speed * n.min_tangential_speed};
  const shapes::Shape& shape = *p.shape;
  const bool exact = n.exact_hit != 0;
  if (exact && shape.kind == shapes::Kind::mesh) return bounce_off_mesh(shape, rebound, b, s);
  visit(shape, [&](const auto& lanes) __attribute__((always_inline)) {
    if (exact) return bounce_exactly(lanes, shape, rebound, b, s.dt);
    for (std::size_t i = 0; i < b.count; i += kLanes) turn_vector(lanes, shape, rebound, b, s.dt, i);
  });
}

/// A bounce that notes its exact hits in columns.
inline void bounce_counted(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  actions::Block noted = b;
  noted.stamp = stamp_of(s);
  bounce(p, noted, s);
}

}  // namespace motes::MOTES_ISA
