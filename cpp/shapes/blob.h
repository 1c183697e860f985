// A cloud without a border: three independent normal numbers around a centre. It contains the points within one sigma.
#pragma once

#include "shapes/lanes.h"

namespace motes::MOTES_ISA {

struct BlobLanes {
  Float3 center;
  float sigma;

  static MOTES_INLINE BlobLanes from(const shapes::Shape& s) {
    const auto blob = s.as<shapes::numbers::blob>();
    return {of(blob.center), blob.sigma};
  }
  MOTES_INLINE Mask contains(Floats3 p) const {
    const Floats3 d = p - all3(center);
    return dot(d, d) <= sigma * sigma;
  }
  MOTES_INLINE Floats3 sample(Draws& draws) const {
    const Uints4 bits = draws.bits();
    Floats3 n{};
    Floats unused;
    normal_pair(bits.a, bits.b, n.x, n.y);
    normal_pair(bits.c, bits.d, n.z, unused);
    return all3(center) + n * sigma;
  }
  MOTES_INLINE Hit hit(Floats3, Floats3) const { return no_hit(); }
};

}  // namespace motes::MOTES_ISA
