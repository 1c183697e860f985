// Finds out whether a picture shows anything of a system, for warnings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/session/report.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Returns where this calculator's particles of each system are to the picture that it has projected to so many
/// records. Where there are none, particles are looked at one by one, but only in the first picture of a system and in
/// each kLaterPictures-th; in others they are `unknown`. `pictures`: counted here, for each system.
std::vector<Sighted> sighted(const Script& script, const Calculator& calculator,
                             const std::vector<std::uint64_t>& records, std::vector<std::uint64_t>& pictures);

inline constexpr std::uint64_t kLaterPictures = 24;

}  // namespace motes::engine
