// Measures how deeply touching spheres overlap: tells whether sub-steps are short enough for a pile.
#pragma once

#include "interactions/cell_list.h"

namespace motes::interactions {

/// Spheres in their cells, with radii in the order of the cells.
struct Spheres {
  const Cells* cells;
  const Crowd* crowd;  // their present positions
  const float* radius = nullptr;  // null: all have same_radius
  float same_radius = 0;          // m
  bool ghosts_alone = false;      // pairs are of an own sphere and a ghost

  float radius_at(std::size_t place) const { return radius != nullptr ? radius[place] : same_radius; }
};

/// Returns the 99th percentile of overlaps of touching pairs, relative to the sum of both radii; 0 if none touch.
/// Samples about a thousand particles of `first` and all particles of `second` that they touch; both may be the same.
float overlap_99(const Spheres& first, const Spheres& second);

}  // namespace motes::interactions
