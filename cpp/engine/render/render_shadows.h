// render: shadows that particles throw, on each other and on solids.
#pragma once

#include "engine/render/render.h"

namespace motes::engine {

/// Collective among the ranks that calculate or draw: sums up the optical depth of all ranks' particles in each light's
/// grid, exactly, so that all have the same shadows. Does nothing where no particle throws any.
void gather_shadows(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter);

}  // namespace motes::engine
