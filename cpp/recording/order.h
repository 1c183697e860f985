// sort: particles in the order of drawing.
#pragma once

#include "actions/action.h"
#include "particles/store.h"

namespace motes::recording {

/// Sorts the particles for which the action's condition holds by their distance from the eye along the look, far ones
/// first, then by id; the others keep their places. What is no number comes last.
void order(const actions::Action& sort, particles::Store& store);

}  // namespace motes::recording
