// Displacements in space with periodic ends, by lane: see Ends.
#pragma once

#include "interactions/grains.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Floats shortest(Floats way, const interactions::Ends& ends, int axis) {
  const Floats length = all(ends.length[axis]), rest = all(ends.rest[axis]), half = all(ends.half[axis]);
  const Floats back = way - length - rest, forth = way + length + rest;
  return select(way > half, back, select(way < -half, forth, way));
}
/// Returns the displacement to the nearest image.
MOTES_INLINE Floats3 shortest(const Floats3& way, const interactions::Ends& ends) {
  if (!ends.any) return way;
  return {shortest(way.x, ends, 0), shortest(way.y, ends, 1), shortest(way.z, ends, 2)};
}

inline float shortest(float way, const interactions::Ends& ends, int axis) {
  if (way > ends.half[axis]) return way - ends.length[axis] - ends.rest[axis];
  return way < -ends.half[axis] ? way + ends.length[axis] + ends.rest[axis] : way;
}

}  // namespace motes::MOTES_ISA
