// Which particles a spawn rule makes into parents.
#pragma once

#include <cstdint>
#include <vector>

#include "particles/store.h"
#include "recording/spawn.h"

namespace motes::program {

/// Those of the particles at these indices (ascending) for which `where` holds at a time of the animation (seconds), as
/// events sorted by id.
std::vector<recording::Event> events_of(const recording::Spawn& spawn, double time, const particles::Store& parents,
                                        const std::vector<std::uint32_t>& indices);

}  // namespace motes::program
