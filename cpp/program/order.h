// sort: puts particles into drawing order.
#pragma once

#include <cstdint>
#include <vector>

#include "actions/action.h"
#include "particles/store.h"

namespace motes::program {

/// Sorts the particles for which the action's condition holds by their distance from the eye along the look direction,
/// far ones first, then by id; the others keep their places. NaN comes last. Returns where particles came from: the one
/// now at index i was at index result[i]. `time`: seconds of the animation, for the condition.
std::vector<std::uint32_t> order(const actions::Action& sort, double time, particles::Store& store,
                                 threads::Pool& pool = threads::alone());

}  // namespace motes::program
