// A cheap first test for paths that stay clear of a box's faces.
#pragma once

#include "shapes/lanes.h"

namespace motes::MOTES_ISA {

/// Compares the distance from the faces along that axis on which it is largest with the longest component of the path.
/// Most particles are far from a box or deep inside it, so most vectors need nothing else.
class Clear {
 public:
  MOTES_INLINE Clear(Float3 low, Float3 high) : low_(low), high_(high) {
    const Floats size = max(largest(all3(low)), largest(all3(high)));
    rounding_ = size[0] * kRounding + __FLT_MIN__;
  }

  /// Returns true where the path of a velocity may meet a face; lanes that are not finite are undefined. Rounding of
  /// the place, the path and its end is a tenth of what is allowed for.
  MOTES_INLINE Mask may_meet(Floats3 p, Floats3 velocity, float dt) const {
    const auto beyond = [](Floats at, float low, float high)
                            __attribute__((always_inline)) { return max(low - at, at - high); };
    const Floats from = max(max(beyond(p.x, low_.x, high_.x), beyond(p.y, low_.y, high_.y)),
                            beyond(p.z, low_.z, high_.z));  // negative inside
    const Floats reach = largest(velocity) * (dt * (1.0f + kRounding)) + rounding_;
    return (Mask)(abs(from) - reach) >> 31;  // the sign: a comparison would be turned into a vector again
  }

 private:
  static constexpr float kRounding = 0x1p-20f;

  Float3 low_, high_;
  float rounding_;
};

}  // namespace motes::MOTES_ISA
