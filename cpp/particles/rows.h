// Columns of particles as other programs keep them: row by row.
#pragma once

#include <cstddef>

namespace motes::particles {

/// The numbers of an attribute, particle after particle.
struct GivenRows {
  const void* numbers;
  int width;     // numbers per particle: 1 or 3
  bool doubles;  // float64; otherwise float32
};

/// Copies rows first .. last - 1 to as many planes as there are numbers in a row; planes begin with row 0. Returns
/// whether all are finite as float32.
bool to_planes(const GivenRows& rows, std::size_t first, std::size_t last, float* const* planes);

}  // namespace motes::particles
