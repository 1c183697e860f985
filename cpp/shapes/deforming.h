// A mesh that deforms during a frame. Between its two forms, `when` is the fraction of the frame that has passed.
//
//     start                                       end
//     form d0, at q0  ---- displacement u ---->  form d1, at q1        q1 = q0 + u
//                            |
//                  p = q0 + when u, d = (1 - when) d0(q0) + when d1(q1)
//
// The surface is where the distance d is 0. It carries its points along u, which is interpolated between vertices, so
// even a thin sheet that moves by many times its thickness is met on its way. At both ends of the frame d has exactly
// the bits of that end's grid, and it is continuous between them: who stays on one side of d = 0 at all times is on the
// same side as before when the frame ends.
#pragma once

#include "shapes/mesh.h"

namespace motes::MOTES_ISA {

struct DeformingLanes {
  const meshes::Deformation* deformation;
  MeshLanes before, now;  // without their poses: all places are in the body's coordinates

  static MOTES_INLINE DeformingLanes from(const meshes::Deformation& d) {
    return {&d, {d.before, {}, false}, {d.now, {}, false}};
  }

  /// A place of the mesh at both ends of the frame.
  struct Ends {
    Floats3 before, now;
  };

  /// Returns where the point that is at p in between is at both ends.
  __attribute__((noinline)) Ends ends(const Floats3& p, const Floats& when) const {
    const Floats left = 1.0f - when;
    const auto back = [&](Floats3 q) { return p - displacement(0, q) * when; };
    const auto ahead = [&](Floats3 q) { return p + displacement(1, q) * left; };
    return {back(back(p)), ahead(ahead(p))};
  }

  /// Returns the distance, m, at a place.
  __attribute__((noinline)) Floats distance(const Floats3& p, const Floats& when) const {
    const Ends at = ends(p, when);
    const Floats first = before.distance(at.before), last = now.distance(at.now);
    return select(when == 0.0f, first, select(when == 1.0f, last, first * (1.0f - when) + last * when));
  }

  /// Returns the gradient of the distance.
  __attribute__((noinline)) Floats3 slope(const Floats3& p, const Floats& when) const {
    const float h = 0.5f * now.form->cell;
    const auto along = [&](Floats3 step) { return distance(p + step, when) - distance(p - step, when); };
    const Floats none{}, there = all(h);
    return Floats3{along({there, none, none}), along({none, there, none}), along({none, none, there})} * (0.5f / h);
  }

  /// Returns the unit normal on the side given by `outside`; `astray` where there is none.
  MOTES_INLINE Floats3 normal(Floats3 p, Floats when, Mask outside, Floats3 astray) const {
    const Floats3 out = slope(p, when) * select(outside, all(1.0f), all(-1.0f));
    const Floats length = sqrt(dot(out, out));
    const Mask known = length > 0.0f;
    return select(known, out * (1.0f / select(known, length, all(1.0f))), astray);
  }

  /// Returns how far the surface at p would move in a whole frame, m.
  __attribute__((noinline)) Floats3 motion(const Floats3& p, const Floats& when) const {
    const Ends at = ends(p, when);
    const Floats3 carried = at.now - at.before;
    // Along the normal, the speed at which d = 0 moves, which is exact.
    constexpr float kStep = 1.0f / 64.0f;
    const Floats earlier = max(when - kStep, Floats{}), later = min(when + kStep, all(1.0f));
    const Floats rate = (distance(p, later) - distance(p, earlier)) * (1.0f / (later - earlier));
    const Floats3 out = slope(p, when);
    const Floats square = dot(out, out);
    const Mask known = square > 0.0f;
    const Floats missing = (rate + dot(carried, out)) * (-1.0f / select(known, square, all(1.0f)));
    return select(known, carried + out * missing, carried);
  }

  /// Returns the nearest place in the box around both grids.
  MOTES_INLINE Floats3 into_grids(Floats3 p) const {
    const auto within = [&](Floats x, int axis)
                            __attribute__((always_inline)) { return min(max(x, all(low(axis))), all(high(axis))); };
    return {within(p.x, 0), within(p.y, 1), within(p.z, 2)};
  }
  MOTES_INLINE Mask may_meet(Floats3 from, Floats3 to) const {
    const auto along = [&](Floats a, Floats b, int axis) __attribute__((always_inline)) {
      return (max(a, b) >= low(axis)) & (min(a, b) <= high(axis));
    };
    return along(from.x, to.x, 0) & along(from.y, to.y, 1) & along(from.z, to.z, 2);
  }

  /// Returns the fraction of a path, from `begin` to `end` of the frame, just before it first leaves the side given by
  /// `outside`. `start`: the distance at its beginning; `among`: the lanes to follow.
  __attribute__((noinline)) Passage follow(const Floats3& from, const Floats3& to, const Floats& begin, float end,
                                           const Floats& start, const Mask& outside, const Mask& among) const {
    const Floats3 way = to - from;
    const auto at = [&](Floats s) __attribute__((always_inline)) {
      const Mask last = s >= 1.0f;
      return distance(select(last, to, from + way * s), select(last, all(end), begin + (end - begin) * s));
    };
    // How fast the distance may change along the path: the place moves, and so do the points of both forms.
    const Floats rate = sqrt(dot(way, way)) + 2.0f * deformation->most * (end - begin);
    const Floats least = all(0.5f * now.form->cell);
    Mask walking = among & may_meet(from, to) & (rate > 0.0f);
    Mask met{};
    Floats s{}, value = start, low{}, high{}, at_low{}, at_high{};
    while (any(walking)) {
      const Floats stride = max(abs(value) * 0.8f, least) / select(walking, rate, all(1.0f));
      const Floats next = min(s + stride, all(1.0f));
      const Floats there = at(next);
      const Mask passed = walking & ((there > 0.0f) ^ outside);
      met |= passed;
      low = select(passed, s, low);
      high = select(passed, next, high);
      at_low = select(passed, value, at_low);
      at_high = select(passed, there, at_high);
      walking &= ~passed & (next < 1.0f);
      s = select(walking, next, s);
      value = select(walking, there, value);
    }
    for (int i = 0; i < 4 && any(met); ++i) {
      const Floats across = at_low - at_high;
      const Floats guess = 0.98f * at_low / select(across == 0.0f, all(1.0f), across);
      const Floats middle = low + (high - low) * min(max(guess, all(0.05f)), all(0.95f));
      const Floats there = at(middle);
      const Mask passed = (there > 0.0f) ^ outside;
      high = select(passed, middle, high);
      at_high = select(passed, there, at_high);
      low = select(passed, low, middle);
      at_low = select(passed, at_low, there);
    }
    return {met, only(met, low)};
  }

 private:
  static MOTES_INLINE float end_of(const meshes::MeshForm& form, int axis) {
    return form.first[axis] + form.cell * static_cast<float>(form.nodes[axis] - 1);
  }
  MOTES_INLINE float low(int axis) const {
    const float a = before.form->first[axis], b = now.form->first[axis];
    return a < b ? a : b;
  }
  MOTES_INLINE float high(int axis) const {
    const float a = end_of(*before.form, axis), b = end_of(*now.form, axis);
    return a > b ? a : b;
  }

  /// Returns the displacement of the point that is at q at the start (0) or at the end (1) of the frame.
  Floats3 displacement(int end, Floats3 q) const {
    const meshes::Deformation& d = *deformation;
    const float scale = 1.0f / d.cell;
    const auto along = [&](Floats x, int axis) __attribute__((always_inline)) {
      return min(max((x - d.first[axis]) * scale, Floats{}), all(static_cast<float>(d.nodes[axis] - 1)));
    };
    const Floats x = along(q.x, 0), y = along(q.y, 1), z = along(q.z, 2);
    const Ints i = min_ints(to_ints(x), all_ints(d.nodes[0] - 2));
    const Ints j = min_ints(to_ints(y), all_ints(d.nodes[1] - 2));
    const Ints k = min_ints(to_ints(z), all_ints(d.nodes[2] - 2));
    const Floats part_x = x - to_floats(i), part_y = y - to_floats(j), part_z = z - to_floats(k);
    const int row = d.nodes[0], layer = d.nodes[0] * d.nodes[1];
    const Ints at = i + j * row + k * layer;
    const auto mix = [](Floats a, Floats b, Floats part) __attribute__((always_inline)) { return a + (b - a) * part; };
    const auto component = [&](const float* plane) __attribute__((always_inline)) {
      Floats edge[4];
      for (int e = 0; e < 4; ++e) {
        const Pair ends = gather_pairs(plane + (e & 1) * row + (e >> 1) * layer, at);
        edge[e] = mix(ends.first, ends.second, part_x);
      }
      return mix(mix(edge[0], edge[1], part_y), mix(edge[2], edge[3], part_y), part_z);
    };
    const float* const* planes = d.displacement[end];
    return {component(planes[0]), component(planes[1]), component(planes[2])};
  }
};

}  // namespace motes::MOTES_ISA
