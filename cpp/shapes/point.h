// A point: every sample is the point itself; it contains nothing.
#pragma once

#include "shapes/lanes.h"

namespace motes::MOTES_ISA {

struct PointLanes {
  Float3 point;

  static MOTES_INLINE PointLanes from(const shapes::Shape& s) { return {of(s.as<shapes::numbers::point>().position)}; }
  MOTES_INLINE Mask contains(Floats3) const { return Mask{}; }
  MOTES_INLINE Floats3 sample(Draws&) const { return all3(point); }
  MOTES_INLINE Hit hit(Floats3, Floats3) const { return no_hit(); }
};

}  // namespace motes::MOTES_ISA
