// What the exact tests of all shapes share. They work in double precision on places of single precision, so their
// rounding is a 10^8th of the distance between two neighbouring places.
//
// The side of a place depends only on the place, and a path between places on two sides meets the surface by
// definition. Rounding may affect where it meets the surface, but not whether.
#pragma once

#include "shapes/exact.h"

namespace motes::MOTES_ISA {

inline constexpr double kFar = __builtin_inf();

MOTES_INLINE Doubles of_path(Doubles part) { return min(max(part, Doubles{}), all_doubles(1.0)); }

MOTES_INLINE Doubles3 unit(Doubles3 v) { return v * (1.0 / sqrt(max(dot(v, v), all_doubles(1e-300)))); }

/// Makes a Met. If the normal, due to rounding, does not point back along the path, it becomes straight back.
MOTES_INLINE Met met(Longs mask, Doubles part, Doubles3 normal, Doubles3 way) {
  const Longs astray = mask & ~(Longs)(dot(normal, way) < 0.0);
  if (any(astray)) normal = select(astray, unit(way) * all_doubles(-1.0), normal);
  return {mask, select(mask, of_path(part), Doubles{}), normal};
}

}  // namespace motes::MOTES_ISA
