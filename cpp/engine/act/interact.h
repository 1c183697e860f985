// interact: particles see each other, at the interaction's place in the list (paper 3.1.5). Calculators
//   1. clear the dead, and find the particles that have left their domain;
//   2. agree on the reach of the action: an all-reduce of maxima with a failure flag;
//   3. send one message to each domain within reach: its new migrants, and ghosts of the particles it may see;
//   4. act on their own particles.
#pragma once

#include <cstddef>

#include "actions/action.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// A pair interaction: its action in the list of the first system, and the systems that take part.
struct Interaction {
  const actions::Action* action = nullptr;
  const actions::Action* counterpart = nullptr;  // contact of two systems: the action of the second; else null
  std::size_t item = 0;  // index of the action in the first system's list
  std::size_t systems[2] = {};
  std::size_t count = 1;  // number of systems: two if they interact with each other
  double gravity[2] = {};  // collide: of what precedes it in the lists, m/s2
  std::uint64_t newborn_from[2] = {UINT64_MAX, UINT64_MAX};  // ids from here on collide for the first time
  Collided collided[2] = {};  // particles that have collided in this sub-step
  bool collides_again[2] = {};  // there are more collisions in this sub-step
  std::uint32_t law[2] = {};  // number of the law among each list's laws that keep neighbour lists, from 0
  std::uint32_t substep = 0;  // number of the sub-step since the run's start, from 1
  double time = 0;  // start of the sub-step, seconds of the animation
  float start = 0, end = 1;  // start and end of the sub-step, as fractions of the frame
  bool last = false;  // the frame's last sub-step
};

/// Runs an interaction. Returns false if a calculator has failed: then all leave the list and continue with the report.
/// Collective over calculators.
bool interact(Rank& rank, const Script& script, Calculator& calculator, const Round& round,
              const Interaction& interaction);

/// Tells the other calculators, at their first interaction, that this one failed before it ran the list.
void say_failed(Rank& rank, const Round& round);

}  // namespace motes::engine
