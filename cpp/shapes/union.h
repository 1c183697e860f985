// Several shapes as one: contains what any part contains; drawn from a part picked by measure; hit at the nearest part.
#pragma once

#include "shapes/lanes.h"

namespace motes::MOTES_ISA {

struct UnionLanes {
  const shapes::Shape* part;
  int parts;

  static MOTES_INLINE UnionLanes from(const shapes::Shape& s) { return {s.part, s.parts}; }
  // In rare_lanes.cpp, where the parts' code is.
  Mask contains(const Floats3& p) const;
  Floats3 sample(Draws& draws) const;
  Hit hit(const Floats3& p, const Floats3& path) const;
};

}  // namespace motes::MOTES_ISA
