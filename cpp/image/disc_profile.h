// The light of a disc by the distance from its middle, for footprints and for kernels.
#pragma once

#include "simd/simd.h"

namespace motes::image {

struct DiscProfile {
  /// Returns the light, relative to that in the middle, at a distance of sqrt(q) radii; 0 <= q < 1.
  template <class Number>
  static MOTES_INLINE Number weight(Number q) {
    return (1 - q) * (1 - q);
  }
};

}  // namespace motes::image
