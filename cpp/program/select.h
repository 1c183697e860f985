// Selects the particles of a store that fulfil a condition: for callbacks, sort, and the parents of children.
#pragma once

#include <cstdint>
#include <vector>

#include "actions/action.h"
#include "particles/store.h"
#include "shapes/shape.h"

namespace motes::program {

/// Returns ascending indices of the particles begin.. for which `where` holds at `time` (seconds of the animation); an
/// empty `where` holds for all. Changes nothing.
std::vector<std::uint32_t> select(const actions::Expression& where, const std::vector<shapes::Shape>& shapes,
                                  double time, particles::Store& store, std::size_t begin = 0);

}  // namespace motes::program
