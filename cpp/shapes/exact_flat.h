// Exact tests of planes and of flat pieces of them.
#pragma once

#include "shapes/exact_met.h"

namespace motes::MOTES_ISA {

struct ExactPlane {
  Double3 point, normal;

  static MOTES_INLINE ExactPlane of(const shapes::Shape& s) {
    const auto plane = s.as<shapes::numbers::plane>();
    return {doubles_of(plane.point), unit(doubles_of(plane.normal))};
  }
  MOTES_INLINE Doubles height(Doubles3 p) const { return dot(p - all3(point), all3(normal)); }

  MOTES_INLINE Longs contains(Doubles3 p) const { return (Longs)(height(p) <= 0.0); }

  /// Returns where paths meet the plane. One-sided: every downward path that ends on the plane or below meets it, at
  /// once if it begins there.
  MOTES_INLINE Met meet(Doubles3 from, Doubles3 to) const {
    const Doubles before = height(from), after = height(to);
    const Longs mask = (Longs)(after <= 0.0) & (Longs)(after < before);
    if (!any(mask)) return Met{};
    return met(mask, before / (before - after), all3(normal), to - from);
  }
  /// Returns where paths meet the plane, from both sides.
  MOTES_INLINE Met meet_both(Doubles3 from, Doubles3 to) const {
    return meet_piece(from, to, [](Doubles3) __attribute__((always_inline)) { return ~Longs{}; });
  }
  template <class Within>
  MOTES_INLINE Met meet_piece(Doubles3 from, Doubles3 to, const Within& within) const {
    const Doubles before = height(from), after = height(to);
    const Longs above = (Longs)(before > 0.0);
    // No path ends on the plane; one that begins there may leave to either side.
    const Longs crosses = (above & (Longs)(after <= 0.0)) | ((Longs)(before < 0.0) & (Longs)(after >= 0.0));
    if (!any(crosses)) return Met{};
    const Doubles part = select(crosses, of_path(before / (before - after)), Doubles{});
    const Doubles3 way = to - from;
    return met(crosses & within(from + way * part), part,
               all3(normal) * select(above, all_doubles(1.0), all_doubles(-1.0)), way);
  }
};

/// Tolerance at edges, so pieces that share an edge leave no gap between them.
inline constexpr double kSeam = 0x1p-40;

/// The piece origin + a u + b v of a plane: a and b in 0..1, and a + b <= 1 for a triangle.
struct ExactEdges {
  ExactPlane plane;
  Double3 to_a, to_b;  // reciprocal vectors of the edges
  bool triangle;

  static MOTES_INLINE ExactEdges of(Double3 origin, Double3 u, Double3 v, bool triangle) {
    const Double3 across = cross(u, v);
    const double scale = 1.0 / dot(across, across);
    return {{origin, unit(across)}, cross(v, across) * scale, cross(across, u) * scale, triangle};
  }
  MOTES_INLINE Met meet(Doubles3 from, Doubles3 to) const {
    return plane.meet_piece(from, to, [&](Doubles3 at) __attribute__((always_inline)) {
      const Doubles a = dot(at - all3(plane.point), all3(to_a)), b = dot(at - all3(plane.point), all3(to_b));
      const Doubles most = triangle ? a + b : max(a, b);
      return (Longs)(a >= -kSeam) & (Longs)(b >= -kSeam) & (Longs)(most <= 1.0 + kSeam);
    });
  }
};

struct ExactRectangle {
  ExactEdges edges;

  static MOTES_INLINE ExactRectangle of(const shapes::Shape& s) {
    const auto rectangle = s.as<shapes::numbers::rectangle>();
    return {ExactEdges::of(doubles_of(rectangle.origin), doubles_of(rectangle.u), doubles_of(rectangle.v), false)};
  }
  MOTES_INLINE Met meet(Doubles3 from, Doubles3 to) const { return edges.meet(from, to); }
};

struct ExactTriangle {
  ExactEdges edges;

  static MOTES_INLINE ExactTriangle of(const shapes::Shape& s) {
    const auto triangle = s.as<shapes::numbers::triangle>();
    const Double3 origin = doubles_of(triangle.p0);
    return {ExactEdges::of(origin, doubles_of(triangle.p1) - origin, doubles_of(triangle.p2) - origin, true)};
  }
  MOTES_INLINE Met meet(Doubles3 from, Doubles3 to) const { return edges.meet(from, to); }
};

struct ExactDisc {
  ExactPlane plane;
  double radius, inner;

  static MOTES_INLINE ExactDisc of(const shapes::Shape& s) {
    const auto disc = s.as<shapes::numbers::disc>();
    return {{doubles_of(disc.center), unit(doubles_of(disc.normal))}, disc.radius, disc.inner_radius};
  }
  MOTES_INLINE Met meet(Doubles3 from, Doubles3 to) const {
    return plane.meet_piece(from, to, [&](Doubles3 at) __attribute__((always_inline)) {
      const Doubles3 d = at - all3(plane.point);
      const Doubles distance2 = dot(d, d);
      return (Longs)(distance2 <= radius * radius) & (Longs)(distance2 >= inner * inner);
    });
  }
};

}  // namespace motes::MOTES_ISA
