// sort: particles in the order of drawing.
#pragma once

#include <cstdint>
#include <vector>

#include "actions/action.h"
#include "particles/store.h"

namespace motes::recording {

/// Sorts the particles for which the action's condition holds by their distance from the eye along the look, far ones
/// first, then by id; the others keep their places. NaN comes last. Returns where each particle came from: the one that
/// was at place [i] is at place i now.
std::vector<std::uint32_t> order(const actions::Action& sort, particles::Store& store);

}  // namespace motes::recording
