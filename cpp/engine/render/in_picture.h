// Finds out whether a picture shows any particles of a system, for warnings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/session/report.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Returns where this calculator's particles of each system are relative to the picture. `records`: the number of
/// records they were projected to, per system. Without records all particles are checked, but only in a system's first
/// picture and every kLaterPictures-th; in other pictures the result is `unknown`. `pictures`: a counter per system,
/// updated here.
std::vector<Sighted> sighted(const Script& script, const Calculator& calculator,
                             const std::vector<std::uint64_t>& records, std::vector<std::uint64_t>& pictures);

inline constexpr std::uint64_t kLaterPictures = 24;

}  // namespace motes::engine
