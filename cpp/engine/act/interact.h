// interact: particles see each other, at the interaction's place in the list (paper 3.1.5). Calculators
//   1. clear the dead, and find the particles that have left their domain;
//   2. agree on the reach of the action: an all-reduce of maxima with a failure flag;
//   3. send one message to each domain within reach: its new migrants, and ghosts of the particles it may see;
//   4. act on their own particles.
// interactions/pair_action.h shows which action needs what of this.
#pragma once

#include <cstddef>

#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"
#include "interactions/sides.h"

namespace motes::engine {

/// A pair interaction as the lists of its systems tell. All ranks that calculate know it before any particle is asked.
struct Interaction {
  interactions::Meeting meeting;  // the sides' systems and actions, and the sub-step; no particles yet
  std::size_t item = 0;           // index of the action in the first system's list
  Collided collided[2] = {};      // particles of each side that have collided in this sub-step
  bool collides_again[2] = {};    // there are more collisions in this sub-step
};

/// Runs an interaction. Returns false if a calculator has failed: then all leave the list and continue with the report.
/// Collective over calculators.
bool interact(Rank& rank, const Script& script, Calculator& calculator, const Round& round,
              const Interaction& interaction);

/// Tells the other calculators, at their first interaction, that this one failed before it ran the list.
void say_failed(Rank& rank, const Round& round);

}  // namespace motes::engine
