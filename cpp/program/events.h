// Finds the particles that a spawn rule makes parents.
#pragma once

#include <cstdint>
#include <vector>

#include "particles/store.h"
#include "recording/spawn.h"

namespace motes::program {

/// Returns the finite particles at these ascending indices for which `where` holds at `time` (seconds of the
/// animation), as events sorted by id.
std::vector<recording::Event> events_of(const recording::Spawn& spawn, double time, const particles::Store& parents,
                                        const std::vector<std::uint32_t>& indices);

}  // namespace motes::program
