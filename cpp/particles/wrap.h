// Wrapping of positions in periodic space: after particles move, they are put back into the interval of each periodic
// axis, and the attribute `crossings` counts how often they have crossed its ends.
#pragma once

#include <cstddef>

#include "particles/store.h"
#include "threads/pool.h"

namespace motes::particles {

/// Wraps `count` positions. `position`, `crossings`: planes of one axis, starting at the first particle.
void wrap(const Period& period, std::size_t count, float* position, float* crossings);

/// Wraps all positions of a store whose schema has periods; does nothing otherwise.
void wrap(Store& store, threads::Pool& pool = threads::alone());

}  // namespace motes::particles
