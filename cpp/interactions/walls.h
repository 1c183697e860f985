// Walls of contact: what they do to the particles that touch them. Nothing is said to other ranks, since walls are
// known to all.
#pragma once

#include "interactions/act.h"

namespace motes::interactions {

/// The particles of one system as kernels see them, and what the law says of them, by place.
struct PlacedParticles {
  const Cells* cells = nullptr;
  const float* column[party_columns] = {};
  float* out[kMostResults] = {};
};

/// Adds what the action's walls do to `out`, and writes to the store what the particles remember of them. Walls act in
/// the order in which the script gives them.
void touch_walls(const actions::Action& action, const Side& side, float dt, const PlacedParticles& placed,
                 threads::Pool& pool);

}  // namespace motes::interactions
