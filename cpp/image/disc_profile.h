// How much light a disc has at each distance from its middle, for footprints and for kernels.
#pragma once

#include "simd/simd.h"

namespace motes::image {

struct DiscProfile {
  /// The part of its light at the square q of the distance from its middle, in radii; 0 <= q < 1.
  template <class Number>
  static MOTES_INLINE Number weight(Number q) {
    return (1 - q) * (1 - q);
  }
};

}  // namespace motes::image
