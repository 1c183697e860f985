// The walls of a frame: which shapes they are, and the forces on them. All ranks know them from the verdict.
#pragma once

#include <array>
#include <optional>

#include "engine/state/script.h"

namespace motes::engine {

/// Adds the forces of a round's verdict to Script::walls; the first round of a frame begins anew.
void note_walls(Script& script, const Round& round);

/// Returns the mean force, N, on a wall of the last frame and its torque, N m, about the wall's origin. A wall is the
/// shape that a contact was given. A mesh is also recognised by its place at the frame's end, or if no other wall has
/// the same mesh. Returns nothing if there is no such wall, or more than one.
std::optional<std::array<double, 6>> force_on(const Script& script, const shapes::Shape& wall, int substeps);

/// Returns a wall's mean force and torque.
std::array<double, 6> mean_of(const interactions::WallSum& sum, int substeps);

}  // namespace motes::engine
