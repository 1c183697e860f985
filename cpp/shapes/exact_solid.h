// Exact tests of boxes and balls.
#pragma once

#include "shapes/exact_met.h"

namespace motes::MOTES_ISA {

struct ExactBox {
  Double3 low, high;

  static MOTES_INLINE ExactBox of(const shapes::Shape& s) {
    const auto box = s.as<shapes::numbers::box>();
    return {doubles_of(box.low), doubles_of(box.high)};
  }
  MOTES_INLINE Longs contains(Doubles3 p) const {
    return (Longs)(p.x >= low.x) & (Longs)(p.x <= high.x) & (Longs)(p.y >= low.y) & (Longs)(p.y <= high.y) &
           (Longs)(p.z >= low.z) & (Longs)(p.z <= high.z);
  }

  MOTES_INLINE Met meet(Doubles3 from, Doubles3 to) const {
    const Longs inside = contains(from), differs = inside ^ contains(to);
    if (!any(differs | (~inside & ~beside(from, to)))) return Met{};
    const Doubles3 way = to - from;
    Ends ends{all_doubles(-kFar), all_doubles(kFar), {}, {}};
    Longs apart{};
    slab(from.x, way.x, low.x, high.x, {1, 0, 0}, ends, apart);
    slab(from.y, way.y, low.y, high.y, {0, 1, 0}, ends, apart);
    slab(from.z, way.z, low.z, high.z, {0, 0, 1}, ends, apart);
    const Longs through =
        ~inside & ~apart & (Longs)(ends.enter <= ends.leave) & (Longs)(ends.enter >= 0.0) & (Longs)(ends.enter <= 1.0);
    return met(differs | through, select(inside, ends.leave, ends.enter),
               select(inside, ends.leave_normal, ends.enter_normal), way);
  }

 private:
  /// Returns whether both places are beyond the same face.
  MOTES_INLINE Longs beside(Doubles3 p, Doubles3 q) const {
    const auto along = [](Doubles a, Doubles b, double lo, double hi) __attribute__((always_inline)) {
      return ((Longs)(a < lo) & (Longs)(b < lo)) | ((Longs)(a > hi) & (Longs)(b > hi));
    };
    return along(p.x, q.x, low.x, high.x) | along(p.y, q.y, low.y, high.y) | along(p.z, q.z, low.z, high.z);
  }

  /// The part of a path within the box.
  struct Ends {
    Doubles enter, leave;
    Doubles3 enter_normal, leave_normal;
  };
  static MOTES_INLINE void slab(Doubles p, Doubles d, double lo, double hi, Double3 axis, Ends& ends, Longs& apart) {
    const Longs still = (Longs)(d == 0.0);
    apart |= still & ((Longs)(p < lo) | (Longs)(p > hi));
    const Doubles inverse = 1.0 / select(still, all_doubles(1.0), d);
    const Doubles to_low = (lo - p) * inverse, to_high = (hi - p) * inverse;
    const Doubles3 back = all3(axis) * select((Longs)(d > 0.0), all_doubles(-1.0), all_doubles(1.0));
    const Longs later = ~still & (Longs)(min(to_low, to_high) > ends.enter);
    ends.enter = select(later, min(to_low, to_high), ends.enter);
    ends.enter_normal = select(later, back, ends.enter_normal);
    const Longs sooner = ~still & (Longs)(max(to_low, to_high) < ends.leave);
    ends.leave = select(sooner, max(to_low, to_high), ends.leave);
    ends.leave_normal = select(sooner, back, ends.leave_normal);
  }
};

struct ExactBall {
  Double3 center;
  double radius, inner;

  static MOTES_INLINE ExactBall of(const shapes::Shape& s) {
    const auto sphere = s.as<shapes::numbers::sphere>();
    return {doubles_of(sphere.center), sphere.radius, sphere.inner_radius};
  }
  MOTES_INLINE Longs contains(Doubles3 p) const {
    const Doubles3 d = p - all3(center);
    const Doubles distance2 = dot(d, d);
    return (Longs)(distance2 <= radius * radius) & (Longs)(distance2 >= inner * inner);
  }

  /// Returns whether two places are on different sides of the outer surface.
  MOTES_INLINE Longs parts(Doubles3 from, Doubles3 to) const { return within(from) ^ within(to); }

  MOTES_INLINE Met meet(Doubles3 from, Doubles3 to) const {
    const Doubles3 d = from - all3(center), way = to - from;
    const Longs inside = within(from), differs = parts(from, to);
    const Doubles a = dot(way, way), b = dot(d, way), c = dot(d, d) - radius * radius;
    const Doubles square = b * b - a * c;
    // The path is nearest to the centre between its ends, and within the ball there.
    const Longs through = ~inside & (Longs)(b < 0.0) & (Longs)(a + b > 0.0) & (Longs)(square > 0.0);
    const Longs mask = differs | through;
    if (!any(mask)) return Met{};
    // The roots are (-b - root) / a for paths that enter and (-b + root) / a for paths that leave, written without
    // cancellation.
    const Doubles root = sqrt(max(square, Doubles{}));
    const Longs outwards = inside & (Longs)(b <= 0.0);
    const Doubles above = select(outwards, root - b, select(inside, -c, c));
    const Doubles below = select(outwards, a, select(inside, root + b, root - b));
    const Doubles part = of_path(above / select((Longs)(below > 0.0), below, all_doubles(1.0)));
    const Doubles scale = select(inside, all_doubles(-1.0 / radius), all_doubles(1.0 / radius));
    return met(mask, part, (d + way * part) * scale, way);
  }

 private:
  MOTES_INLINE Longs within(Doubles3 p) const {
    const Doubles3 d = p - all3(center);
    return (Longs)(dot(d, d) <= radius * radius);
  }
};

}  // namespace motes::MOTES_ISA
