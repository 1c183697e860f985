// How deep spheres overlap that touch: what tells whether sub-steps are short enough for a heap.
#pragma once

#include "interactions/cell_list.h"

namespace motes::interactions {

/// Spheres in their cells, and their radii by place.
struct Spheres {
  const Cells* cells;
  const Crowd* crowd;  // where they are now
  const float* radius = nullptr;  // null: all have the same
  float same_radius = 0;          // m

  float radius_at(std::size_t place) const { return radius != nullptr ? radius[place] : same_radius; }
};

/// The 99th percentile of the overlaps of pairs that touch, in parts of the sum of both radii; 0 where none touch. Of a
/// thousand particles of the first side, and all that they touch of the second, which may be the same.
float overlap_99(const Spheres& first, const Spheres& second);

}  // namespace motes::interactions
