// follow_path: steers particles along a chain of segments, toward a point ahead of the nearest one.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

/// A segment of a path, as stored in its table: start point, unit direction, distance of the start along the path, and
/// length.
struct Segment {
  Floats3 from, along;
  Floats start, length;
};

inline constexpr int kSegmentNumbers = 8;

MOTES_INLINE Segment segment(const float* table, int i) {
  const float* v = table + static_cast<std::ptrdiff_t>(kSegmentNumbers) * i;
  return {all3(v), all3(v + 3), all(v[6]), all(v[7])};
}

/// The nearest point of a path: its distance along the path, and the squared distance to it.
struct Closest {
  Floats way, square;
};

MOTES_INLINE Closest closest_on(const float* table, int segments, Floats3 x) {
  Closest found{Floats{}, all(__builtin_inff())};
  for (int i = 0; i < segments; ++i) {
    const Segment s = segment(table, i);
    const Floats way = min(max(dot(x - s.from, s.along), Floats{}), s.length);
    const Floats3 off = x - (s.from + s.along * way);
    const Floats square = dot(off, off);
    const Mask nearer = square < found.square;
    found.square = select(nearer, square, found.square);
    found.way = select(nearer, s.start + way, found.way);
  }
  return found;
}

MOTES_INLINE Floats3 point_of(const float* table, int segments, Floats way) {
  Floats3 found{};
  for (int i = 0; i < segments; ++i) {
    const Segment s = segment(table, i);
    const Floats3 point = s.from + s.along * min(way - s.start, s.length);
    found = select(way >= s.start, point, found);
  }
  return found;
}

inline void follow_path(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::follow_path>(p);
  const float part = __builtin_fminf(n.strength * s.dt, 1.0f);
  const bool loop = n.loop != 0;
  const float* const table = p.bound.table->entries;
  const int segments = p.bound.table->size[0];
  const float* last = table + static_cast<std::ptrdiff_t>(kSegmentNumbers) * (segments - 1);
  const float whole = last[6] + last[7];
  const float ahead = __builtin_fminf(n.look_ahead, whole);
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 x = load3(b, kPositionAt, i), v = load3(b, kVelocityAt, i);
    const Closest closest = closest_on(table, segments, x);
    Floats way = closest.way + ahead;
    way = loop ? select(way >= whole, way - whole, way) : min(way, all(whole));
    const Floats3 toward = point_of(table, segments, way) - x;
    const Floats far = max(sqrt(dot(toward, toward)), all(ahead));
    const Floats3 wanted = toward * (n.speed / far);
    const Mask near = (closest.square <= n.radius * n.radius) & (closest.square < __builtin_inff());
    store3(b, kVelocityAt, i, select(near, v + (wanted - v) * part, v));
  }
}

}  // namespace motes::MOTES_ISA
