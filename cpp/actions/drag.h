// What linear drag does over a time, whatever its length.
#pragma once

#include "simd/elementary.h"

namespace motes::MOTES_ISA {

/// 1 - exp(-t) for t >= 0. The series avoids cancellation where t is small.
MOTES_INLINE Floats part_gone(Floats t) {
  Floats series = all(1.0f / 720.0f);
  series = 1.0f / 120.0f - t * series;
  series = 1.0f / 24.0f - t * series;
  series = 1.0f / 6.0f - t * series;
  series = 0.5f - t * series;
  series = t * (1.0f - t * series);
  return select(t < 0.25f, series, 1.0f - exp(-min(t, all(80.0f))));
}

}  // namespace motes::MOTES_ISA
