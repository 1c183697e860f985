// The plane through a point, with a normal: contains the half-space below it. A sample is always the point itself,
// since no distribution is uniform over an infinite plane.
#pragma once

#include "shapes/lanes.h"

namespace motes::MOTES_ISA {

struct PlaneLanes {
  static constexpr bool kFlat = true;
  Float3 point, normal;

  static MOTES_INLINE PlaneLanes from(const shapes::Shape& s) { return {of(s.number), unit(of(s.number + 3))}; }
  MOTES_INLINE Floats height(Floats3 p) const { return dot(p - all3(point), all3(normal)); }
  MOTES_INLINE Mask contains(Floats3 p) const { return height(p) <= 0.0f; }
  MOTES_INLINE Floats3 sample(Draws&) const { return all3(point); }

  /// One-sided: every path that would end below the plane meets it, and meets it at once if it is already below.
  MOTES_INLINE Hit hit(Floats3 p, Floats3 path) const {
    const Floats before = height(p);
    const Floats change = dot(path, all3(normal));
    const Mask mask = (before + change < 0.0f) & (change < 0.0f);
    const Floats part = max(before / -change, Floats{});
    return {mask, select(mask, min(part, all(1.0f)), Floats{}), all3(normal)};
  }
};

/// Where a path crosses the plane of a flat shape, from either side.
struct Crossing {
  Mask mask;
  Floats part;
  Floats3 at, normal;
};

MOTES_INLINE Crossing cross_plane(Float3 point, Float3 normal, Floats3 p, Floats3 path) {
  const Floats before = dot(p - all3(point), all3(normal));
  const Floats change = dot(path, all3(normal));
  // The side on which the next step will see the particle, to the last bit: before + change may give the other side.
  const Floats after = dot((p + path) - all3(point), all3(normal));
  const Mask mask = ((before > 0.0f) & (after <= 0.0f)) | ((before < 0.0f) & (after >= 0.0f));
  const Floats part = select(mask & (change != 0.0f), min(max(before / -change, Floats{}), all(1.0f)), Floats{});
  const Floats side = select(before > 0.0f, all(1.0f), all(-1.0f));
  return {mask, part, p + path * part, all3(normal) * side};
}

}  // namespace motes::MOTES_ISA
