// Sums gravitation over a list of weighted sources, for a few targets.
#pragma once

#include "simd/floats3.h"

namespace motes::MOTES_ISA {

/// Writes three sums per target. `sources`: x, y, z and weight (magnitude * step * number of particles). `targets`:
/// columns from `begin` to `end`, readable up to the next whole vector.
inline void pull(const float* const* sources, std::size_t count, float epsilon, const float* const* targets,
                 std::size_t begin, std::size_t end, float* sums) {
  for (std::size_t i = begin; i < end; i += kLanes) {
    const Floats3 at = {load(targets[0] + i), load(targets[1] + i), load(targets[2] + i)};
    Floats3 sum{};
    for (std::size_t j = 0; j < count; ++j) {
      const Floats3 r = {sources[0][j] - at.x, sources[1][j] - at.y, sources[2][j] - at.z};
      const Floats r2 = dot(r, r);
      sum = sum + only(r2 > 0.0f, r * (sources[3][j] / (sqrt(r2) * (r2 + epsilon))));
    }
    for (std::size_t k = 0; k < kLanes && i + k < end; ++k) {
      float* to = sums + 3 * (i + k - begin);
      to[0] = sum.x[k];
      to[1] = sum.y[k];
      to[2] = sum.z[k];
    }
  }
}

}  // namespace motes::MOTES_ISA
