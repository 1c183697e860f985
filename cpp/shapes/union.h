// Several shapes as one: it contains what any part contains; it samples a part picked by measure; a path hits its
// nearest part.
#pragma once

#include "shapes/lanes.h"

namespace motes::MOTES_ISA {

struct UnionLanes {
  const shapes::Shape* part;
  int parts;

  static MOTES_INLINE UnionLanes from(const shapes::Shape& s) { return {s.part, s.parts}; }
  // Defined in rare_lanes.cpp, which has the code of the parts.
  Mask contains(const Floats3& p) const;
  Mask may_meet(const Floats3& p, const Floats3& to) const;
  Floats3 sample(Draws& draws) const;
  Hit hit(const Floats3& p, const Floats3& path) const;
};

}  // namespace motes::MOTES_ISA
