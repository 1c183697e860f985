// The points between two cones that share an apex and end at a base; the radii are those at the base. With inner radius
// 0 it is solid; with equal radii it is the side only, without thickness, open at the base.
#pragma once

#include "shapes/shell.h"

namespace motes::MOTES_ISA {

struct ExactShell;  // in exact_shell.h

struct ConeLanes {
  using Exact = ExactShell;
  Shell shell;
  float radius, inner;

  static MOTES_INLINE ConeLanes from(const shapes::Shape& s) {
    const auto cone = s.as<shapes::numbers::cone>();
    const Float3 axis = minus(of(cone.base), of(cone.apex));
    const float height = __builtin_sqrtf(dot(axis, axis));
    const float radius = cone.radius, inner = cone.inner_radius;
    return {Shell::from(s, {0.0f, radius / height}, {0.0f, inner / height}), radius, inner};
  }
  MOTES_INLINE Mask contains(Floats3 p) const { return shell.contains(p); }
  MOTES_INLINE Floats3 sample(Draws& draws) const {
    const Uints4 bits = draws.bits();
    // Uniform by volume: cross-sections grow with the square of the distance from the apex, and so do the rings of the
    // side.
    const Floats u = unit(bits.a);
    const Floats along = inner == radius ? sqrt(u) : cube_root(u);
    const float inner2 = inner * inner;
    const Floats r = sqrt(all(inner2) + unit(bits.b) * (radius * radius - inner2));
    return shell.point(along, along * r, unit(bits.c));
  }
  MOTES_INLINE Mask may_meet(Floats3 p, Floats3 to) const { return shell.may_meet(p, to); }
  MOTES_INLINE Hit hit(Floats3 p, Floats3 path) const { return shell.hit(p, path); }
};

}  // namespace motes::MOTES_ISA
