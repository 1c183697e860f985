// The surface of a field of densities: a closed mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "surfaces/field.h"
#include "threads/pool.h"

namespace motes::surfaces {

/// A closed surface whose triangles face outwards; each edge belongs to two of them.
struct Skin {
  std::vector<float> vertices;  // m: x, y, z of each
  std::vector<std::uint32_t> triangles;  // three indices of vertices each
};

/// Returns the surface where the density is kLevel: that of lone particles is at `radius` from their centres. The bits
/// depend only on the sums. Throws std::invalid_argument if it has more than 2^32 vertices.
Skin skin_of(const Field& field, threads::Pool& pool);

}  // namespace motes::surfaces
