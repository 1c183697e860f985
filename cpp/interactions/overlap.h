// Measures how deeply touching spheres overlap: tells whether sub-steps are short enough for a pile.
#pragma once

#include <cstddef>
#include <vector>

#include "interactions/cell_list.h"

namespace motes::interactions {

/// Overlaps of touching pairs, relative to the sum of both radii, of a sample of about a thousand spheres.
class Overlaps {
 public:
  explicit Overlaps(std::size_t spheres) : stride_(1 + spheres / kSample) {}

  /// Returns whether the next sphere is in the sample.
  bool takes_next() { return number_++ % stride_ == 0; }
  /// Adds a pair at a distance whose square is `distance2`, m2; `reach`: the sum of both radii, m.
  void add(float distance2, float reach);
  /// Returns the 99th percentile; 0 if no pairs touch. Reorders the overlaps.
  float percentile_99();

 private:
  static constexpr std::size_t kSample = 1024;

  std::size_t stride_, number_ = 0;
  std::vector<float> found_;
};

/// Spheres in their cells, with radii in the order of the cells.
struct Spheres {
  const Cells* cells;
  const Crowd* crowd;  // their present positions
  const float* radius = nullptr;  // null: all have same_radius
  float same_radius = 0;          // m

  float radius_at(std::size_t place) const { return radius != nullptr ? radius[place] : same_radius; }
};

/// Returns the 99th percentile of overlaps of touching pairs, relative to the sum of both radii; 0 if none touch.
/// Samples about a thousand particles of `first` and all particles of `second` that they touch; both may be the same.
float overlap_99(const Spheres& first, const Spheres& second);

}  // namespace motes::interactions
