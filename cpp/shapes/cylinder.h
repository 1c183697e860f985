// The points whose distance from the axis p0 to p1 is between two radii. With inner radius 0 it is solid; with equal
// radii it is an open tube without thickness; otherwise it is a pipe with a bore.
#pragma once

#include "shapes/shell.h"

namespace motes::MOTES_ISA {

struct ExactShell;  // in exact_shell.h

struct CylinderLanes {
  using Exact = ExactShell;
  Shell shell;
  float radius, inner;

  static MOTES_INLINE CylinderLanes from(const shapes::Shape& s) {
    const auto cylinder = s.as<shapes::numbers::cylinder>();
    const float radius = cylinder.radius, inner = cylinder.inner_radius;
    return {Shell::from(s, {radius, 0.0f}, {inner, 0.0f}), radius, inner};
  }
  MOTES_INLINE Mask contains(Floats3 p) const { return shell.contains(p); }
  MOTES_INLINE Floats3 sample(Draws& draws) const {
    const Uints4 bits = draws.bits();
    // Uniform by volume: the squared distance is uniform.
    const float inner2 = inner * inner;
    const Floats r = sqrt(all(inner2) + unit(bits.b) * (radius * radius - inner2));
    return shell.point(unit(bits.a), r, unit(bits.c));
  }
  MOTES_INLINE Mask may_meet(Floats3 p, Floats3 to) const { return shell.may_meet(p, to); }
  MOTES_INLINE Hit hit(Floats3 p, Floats3 path) const { return shell.hit(p, path); }
};

}  // namespace motes::MOTES_ISA
