// render: shadows that particles cast on each other and on solids.
#pragma once

#include "engine/render/render.h"

namespace motes::engine {

/// Sums the optical depth of all ranks' particles in each light's grid, exactly, so all ranks have the same shadows. No
/// effect if no particles cast shadows. Collective over the ranks that calculate or draw.
void gather_shadows(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter);

}  // namespace motes::engine
