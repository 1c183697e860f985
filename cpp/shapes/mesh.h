// A mesh: its surface, or the inside of a closed one, with a pose that may change.
//
// Inside is where the distance, interpolated between the nodes of the mesh's grid, is not positive. Paths are followed
// in steps of that distance, at least half a cell, until the side changes.
#pragma once

#include "meshes/mesh_form.h"
#include "shapes/lanes.h"

namespace motes::MOTES_ISA {

/// The pose of a rigid body: its origin and its axes.
struct Pose {
  Float3 position, x, y, z;

  MOTES_INLINE Floats3 turn(Floats3 q) const { return all3(x) * q.x + all3(y) * q.y + all3(z) * q.z; }
  MOTES_INLINE Floats3 to_world(Floats3 q) const { return all3(position) + turn(q); }
  MOTES_INLINE Floats3 to_body(Floats3 p) const {
    const Floats3 d = p - all3(position);
    return {dot(d, all3(x)), dot(d, all3(y)), dot(d, all3(z))};
  }
};

/// Returns the pose at a fraction of the frame, from a mesh's numbers: at 0 its place at the start, at 1 that at the
/// end, interpolated in between.
MOTES_INLINE Pose pose_at(const float* number, float part) {
  constexpr int kPlace = shapes::kCountOf<shapes::MeshPlace>;
  const float *end = number, *start = number + kPlace;
  float at[kPlace];
  for (int i = 0; i < kPlace; ++i) at[i] = part == 1.0f ? end[i] : start[i] + (end[i] - start[i]) * part;
  const float scale = 1.0f / __builtin_sqrtf(at[3] * at[3] + at[4] * at[4] + at[5] * at[5] + at[6] * at[6]);
  const float w = at[3] * scale, i = at[4] * scale, j = at[5] * scale, k = at[6] * scale;
  return {{at[0], at[1], at[2]},
          {1.0f - 2.0f * (j * j + k * k), 2.0f * (i * j + k * w), 2.0f * (i * k - j * w)},
          {2.0f * (i * j - k * w), 1.0f - 2.0f * (i * i + k * k), 2.0f * (j * k + i * w)},
          {2.0f * (i * k + j * w), 2.0f * (j * k - i * w), 1.0f - 2.0f * (i * i + j * j)}};
}

/// Where a path changes sides: the fraction of the path before that.
struct Passage {
  Mask mask;
  Floats part;
};

struct MeshLanes {
  const meshes::MeshForm* form;
  Pose pose;
  bool solid;

  static MOTES_INLINE MeshLanes from(const shapes::Shape& s) {
    return {s.form, pose_at(s.number, 1.0f), s.as<shapes::numbers::mesh>().solid != 0.0f};
  }
  MOTES_INLINE bool has_inside() const { return form != nullptr && form->distance != nullptr; }
  MOTES_INLINE Mask contains(Floats3 p) const { return has_inside() ? distance(pose.to_body(p)) <= 0.0f : Mask{}; }
  MOTES_INLINE Floats3 sample(Draws& draws) const {
    if (form == nullptr || form->triangles == 0) return all3(pose.position);
    return pose.to_world(solid && has_inside() ? sample_inside(draws) : sample_surface(draws));
  }
  /// Return the unit normal of the triangle, and the colour of the point, that sample() finds on the surface with these
  /// draws.
  MOTES_INLINE Floats3 sample_normal(Draws& draws) const {
    Floats3 origin{}, u{}, v{};
    sides_at(form->corners, draws.bits(), origin, u, v);
    // Scaled first: squares of small triangles' areas would underflow.
    const Floats3 a = u * (1.0f / scale(u)), b = v * (1.0f / scale(v));
    const Floats3 normal = cross(a, b);
    return pose.turn(normal * (1.0f / sqrt(max(dot(normal, normal), all(1e-30f)))));
  }
  MOTES_INLINE Floats3 sample_color(Draws& draws) const { return mixed(form->colors, draws.bits()); }

  MOTES_INLINE Hit hit(Floats3 p, Floats3 path) const { return meet(p, p + path); }
  MOTES_INLINE Hit meet(Floats3 p, Floats3 there) const {
    if (!has_inside()) return no_hit();
    const Floats3 from = pose.to_body(p), to = pose.to_body(there);
    const Floats start = distance(from);
    const Mask outside = start > 0.0f;
    const Passage passage = follow(from, to, start, outside, ~Mask{});
    const Floats3 normal = normal_at(from + (to - from) * passage.part, to - from, outside);
    return {passage.mask, passage.part, pose.turn(normal)};
  }

  MOTES_INLINE Mask may_meet(Floats3 p, Floats3 to) const {
    return has_inside() ? may_meet_in_body(pose.to_body(p), pose.to_body(to)) : Mask{};
  }
  /// Returns whether the box around a path, in the body's coordinates, touches the grid's box.
  MOTES_INLINE Mask may_meet_in_body(Floats3 from, Floats3 to) const {
    const auto along = [&](Floats a, Floats b, int axis) __attribute__((always_inline)) {
      return (max(a, b) >= form->first[axis]) & (min(a, b) <= grid_end(axis));
    };
    return along(from.x, to.x, 0) & along(from.y, to.y, 1) & along(from.z, to.z, 2);
  }

  /// Returns the distance, m, at a place in the body's coordinates; beyond the grid as at its border, so positive.
  MOTES_INLINE Floats distance(Floats3 q) const {
    const Cell c = cell_of(q);
    const Floats low = mix(mix(c.corner[0], c.corner[1], c.x), mix(c.corner[2], c.corner[3], c.x), c.y);
    const Floats high = mix(mix(c.corner[4], c.corner[5], c.x), mix(c.corner[6], c.corner[7], c.x), c.y);
    return mix(low, high, c.z);
  }

  /// Returns the unit normal on the side from which a path along `way` comes.
  MOTES_INLINE Floats3 normal_at(Floats3 q, Floats3 way, Mask outside) const {
    const Cell c = cell_of(q);
    const Floats* v = c.corner;
    const Floats3 slope = {mix(mix(v[1] - v[0], v[3] - v[2], c.y), mix(v[5] - v[4], v[7] - v[6], c.y), c.z),
                           mix(mix(v[2] - v[0], v[3] - v[1], c.x), mix(v[6] - v[4], v[7] - v[5], c.x), c.z),
                           mix(mix(v[4] - v[0], v[5] - v[1], c.x), mix(v[6] - v[2], v[7] - v[3], c.x), c.y)};
    const Floats3 out = slope * select(outside, all(1.0f), all(-1.0f));
    const Floats3 found = out * (1.0f / sqrt(max(dot(out, out), all(1e-30f))));
    // If the slope is 0, or would mean that the path leaves: straight back.
    const Floats3 back = way * (-1.0f / sqrt(max(dot(way, way), all(1e-30f))));
    return select((dot(found, back) > 0.0f) | (dot(way, way) == 0.0f), found, back);
  }

  /// Returns the fraction of a path just before it first leaves the side given by `outside`. `start`: the distance at
  /// `from`; `among`: the lanes to follow.
  MOTES_INLINE Passage follow(Floats3 from, Floats3 to, Floats start, Mask outside, Mask among) const {
    const Floats3 way = to - from;
    Floats enter{}, leave = all(1.0f);
    clip(from.x, way.x, 0, enter, leave);
    clip(from.y, way.y, 1, enter, leave);
    clip(from.z, way.z, 2, enter, leave);
    const Mask open = among & (enter <= leave);
    if (!any(open)) return {Mask{}, Floats{}};
    // Clipped to the grid's box: relative to a very long path, steps could vanish.
    const Floats3 first = into_grid(from + way * enter);
    const Floats3 last = into_grid(select(leave >= 1.0f, to, from + way * leave));
    const Stretched path{first, last};
    const Mask enters = enter > 0.0f;
    const Floats begin = any(enters & open) ? select(enters, distance(first), start) : start;
    const Bracket bracket = march(path, begin, open, outside);
    const Floats within = refine(path, bracket, outside);
    return {bracket.mask, only(bracket.mask, enter + within * (leave - enter))};
  }

  /// Returns the nearest place in the grid, in the body's coordinates.
  MOTES_INLINE Floats3 into_grid(Floats3 q) const {
    return {min(max(q.x, all(form->first[0])), all(grid_end(0))), min(max(q.y, all(form->first[1])), all(grid_end(1))),
            min(max(q.z, all(form->first[2])), all(grid_end(2)))};
  }

 private:
  struct Cell {
    Floats x, y, z;  // 0..1 between its nodes
    Floats corner[8];  // distances at the corners, x fastest
  };
  struct Stretched {
    Floats3 first, last;
    MOTES_INLINE Floats3 at(Floats s) const { return select(s >= 1.0f, last, first + (last - first) * s); }
  };
  /// Where the side changes: after `low`, and at `high` at the latest; and the distances at both.
  struct Bracket {
    Mask mask;
    Floats low, high, at_low, at_high;
  };

  MOTES_INLINE float grid_end(int axis) const {
    return form->first[axis] + form->cell * static_cast<float>(form->nodes[axis] - 1);
  }
  static MOTES_INLINE Floats mix(Floats a, Floats b, Floats part) { return a + (b - a) * part; }

  MOTES_INLINE Cell cell_of(Floats3 q) const {
    const float scale = 1.0f / form->cell;
    const auto along = [&](Floats x, int axis) __attribute__((always_inline)) {
      return min(max((x - form->first[axis]) * scale, Floats{}), all(static_cast<float>(form->nodes[axis] - 1)));
    };
    const Floats x = along(q.x, 0), y = along(q.y, 1), z = along(q.z, 2);
    const Ints i = min_ints(to_ints(x), all_ints(form->nodes[0] - 2));
    const Ints j = min_ints(to_ints(y), all_ints(form->nodes[1] - 2));
    const Ints k = min_ints(to_ints(z), all_ints(form->nodes[2] - 2));
    const int row = form->nodes[0], layer = form->nodes[0] * form->nodes[1];
    const Ints at = i + j * row + k * layer;
    Cell c{x - to_floats(i), y - to_floats(j), z - to_floats(k), {}};
    for (int edge = 0; edge < 4; ++edge) {  // along x: its two nodes are neighbours in memory
      const Pair ends = gather_pairs(form->distance + (edge & 1) * row + (edge >> 1) * layer, at);
      c.corner[2 * edge] = ends.first;
      c.corner[2 * edge + 1] = ends.second;
    }
    return c;
  }

  MOTES_INLINE void clip(Floats from, Floats way, int axis, Floats& enter, Floats& leave) const {
    const float low = form->first[axis], high = grid_end(axis);
    const Floats inverse = 1.0f / select(abs(way) < 1e-30f, all(1e-30f), way);
    const Floats a = (low - from) * inverse, b = (high - from) * inverse;
    enter = max(enter, min(a, b));
    leave = min(leave, max(a, b));
  }

  MOTES_INLINE Bracket march(const Stretched& path, Floats begin, Mask open, Mask outside) const {
    const Floats3 whole = path.last - path.first;
    const Floats per_metre = 1.0f / max(sqrt(dot(whole, whole)), all(1e-30f));
    const float least = 0.5f * form->cell;
    Bracket found{};
    Mask walking = open;
    Floats s{}, before{}, now = begin, then = begin;
    for (;;) {
      const Mask met = walking & ((now > 0.0f) ^ outside);
      found = {found.mask | met, select(met, before, found.low), select(met, s, found.high),
               select(met, then, found.at_low), select(met, now, found.at_high)};
      // Far from the surface, distances are slightly too large.
      const Floats stride = max(abs(now) * 0.8f, all(least)) * per_metre;
      const Mask clear = (s + stride >= 1.0f) & (abs(now) > 4.0f * form->cell);  // no need to check the end
      walking &= ~met & (s < 1.0f) & ~clear;
      if (!any(walking)) return found;
      before = select(walking, s, before);
      then = select(walking, now, then);
      s = select(walking, min(s + stride, all(1.0f)), s);
      now = select(walking, distance(path.at(s)), now);
    }
  }

  MOTES_INLINE Floats refine(const Stretched& path, Bracket b, Mask outside) const {
    if (!any(b.mask)) return Floats{};
    // The distance is nearly linear here, so the secant is nearly exact. A guess just short of it mostly moves the near
    // end, which is the result: three such guesses are as accurate as four secants.
    for (int i = 0; i < 3; ++i) {
      const Floats across = b.at_low - b.at_high;
      const Floats guess = 0.98f * b.at_low / select(across == 0.0f, all(1.0f), across);
      const Floats s = b.low + (b.high - b.low) * min(max(guess, all(0.05f)), all(0.95f));
      const Floats there = distance(path.at(s));
      const Mask passed = (there > 0.0f) ^ outside;
      b.high = select(passed, s, b.high);
      b.at_high = select(passed, there, b.at_high);
      b.low = select(passed, b.low, s);
      b.at_low = select(passed, b.at_low, there);
    }
    return b.low;
  }

  MOTES_INLINE Floats3 sample_surface(Draws& draws) const {
    const Uints4 bits = draws.bits();
    return mixed(form->corners, bits);
  }

  // Returns the weighted mean of three vectors, one per corner of a triangle. `bits` choose the triangle and the point
  // in it, which gives the weights.
  MOTES_INLINE Floats3 mixed(const float* of_corners, const Uints4& bits) const {
    Floats3 origin{}, u{}, v{};
    sides_at(of_corners, bits, origin, u, v);
    Floats a = unit(bits.b), b = unit(bits.c);
    if (form->uneven) {
      // Three random points cut [0, 1] into four parts. The sum of two parts, and the other two, are distributed like
      // the weights of the first corner and the other corners if the density falls to 0 from the first corner on.
      const Floats c = unit(bits.d);
      return origin + u * min(min(a, b), c) + v * (1.0f - max(max(a, b), c));
    }
    // Uniform by area: the far half of the parallelogram is folded onto the near one.
    const Mask far = a + b > 1.0f;
    a = select(far, 1.0f - a, a);
    b = select(far, 1.0f - b, b);
    return origin + u * a + v * b;
  }

  static MOTES_INLINE Floats scale(Floats3 v) { return max(largest(v), all(1e-30f)); }
  MOTES_INLINE void sides_at(const float* of_corners, const Uints4& bits, Floats3& origin, Floats3& u,
                             Floats3& v) const {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const float* c = of_corners + std::size_t{9} * triangle_of(bits.a[lane]);
      set_lane(origin, lane, of(c));
      set_lane(u, lane, minus(of(c + 3), of(c)));
      set_lane(v, lane, minus(of(c + 6), of(c)));
    }
  }

  MOTES_INLINE std::uint32_t triangle_of(std::uint32_t choice) const {
    std::uint32_t first = 0, count = form->triangles - 1;
    while (count > 0) {
      const std::uint32_t half = count / 2;
      const bool above = form->upto[first + half] < choice;
      first = above ? first + half + 1 : first;
      count = above ? count - half - 1 : half;
    }
    return first;
  }

  /// Samples uniformly by volume: draws a cell and a point in it until the point is inside. All attempts belong to one
  /// draw.
  MOTES_INLINE Floats3 sample_inside(Draws& draws) const {
    const std::uint32_t number = draws.draw;
    Uints4 bits = draws.bits();
    Floats3 point{};
    Mask open = ~Mask{};
    for (std::uint32_t attempt = 1;; ++attempt) {
      Floats3 corner{};
      for (std::size_t lane = 0; lane < kLanes; ++lane) set_lane(corner, lane, corner_of(cell_number(bits.a[lane])));
      const Floats3 tried = corner + Floats3{unit(bits.b), unit(bits.c), unit(bits.d)} * form->cell;
      point = select(open, tried, point);
      open &= ~(distance(tried) <= 0.0f);
      if (!any(open)) return point;
      if (attempt == kAttempts) {
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
          if (open[lane] != 0) set_lane(point, lane, deepest_corner(cell_number(bits.a[lane])));
        }
        return point;
      }
      bits = random_bits_of(*draws.keys, *draws.ids, draws.at, particles::made_again(number, attempt));
    }
  }
  static constexpr std::uint32_t kAttempts = 1000;

  MOTES_INLINE std::uint32_t cell_number(std::uint32_t choice) const {
    return form->cells[static_cast<std::size_t>(std::uint64_t{choice} * form->cell_count >> 32)];
  }
  MOTES_INLINE Float3 corner_of(std::uint32_t node) const {
    const auto row = static_cast<std::uint32_t>(form->nodes[0]), column = static_cast<std::uint32_t>(form->nodes[1]);
    const std::uint32_t i = node % row, j = node / row % column, k = node / row / column;
    return {form->first[0] + form->cell * static_cast<float>(i), form->first[1] + form->cell * static_cast<float>(j),
            form->first[2] + form->cell * static_cast<float>(k)};
  }
  MOTES_INLINE Float3 deepest_corner(std::uint32_t cell) const {
    const auto row = static_cast<std::uint32_t>(form->nodes[0]), column = static_cast<std::uint32_t>(form->nodes[1]);
    std::uint32_t best = cell;
    for (std::uint32_t corner = 1; corner < 8; ++corner) {
      const std::uint32_t node = cell + (corner & 1) + ((corner >> 1 & 1) + (corner >> 2) * column) * row;
      if (form->distance[node] < form->distance[best]) best = node;
    }
    return corner_of(best);
  }
};

}  // namespace motes::MOTES_ISA
