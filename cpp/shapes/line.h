// The segment between two points.
#pragma once

#include "shapes/lanes.h"

namespace motes::MOTES_ISA {

struct LineLanes {
  static constexpr bool kDrawsTogether = true;
  Float3 start, along;

  static MOTES_INLINE LineLanes from(const shapes::Shape& s) {
    const auto line = s.as<shapes::numbers::line>();
    return {of(line.p0), minus(of(line.p1), of(line.p0))};
  }
  MOTES_INLINE Mask contains(Floats3) const { return Mask{}; }
  MOTES_INLINE Floats3 sample(Draws& draws) const { return all3(start) + all3(along) * unit(draws.bits().a); }
  MOTES_INLINE Hit hit(Floats3, Floats3) const { return no_hit(); }
};

}  // namespace motes::MOTES_ISA
