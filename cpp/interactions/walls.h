// Walls of contact push the particles that touch them. This needs no messages, since all ranks know all walls.
#pragma once

#include "interactions/sides.h"
#include "interactions/wall_sums.h"

namespace motes::interactions {

/// The grains of one system, and what pushes them, by place.
struct PlacedGrains {
  const Cells* cells = nullptr;
  const Grain* grains = nullptr;
  GrainPush* out = nullptr;
};

/// Adds the pushes of the action's walls to `out`, and writes the particles' touches with walls to the store. Walls act
/// in the order in which the script gives them. Returns the forces of particles on the walls that they touch.
WallSums touch_walls(const Side& side, const SubStep& step, const PlacedGrains& placed, threads::Pool& pool);

}  // namespace motes::interactions
