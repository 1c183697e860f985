// interact: particles see each other, at their place in the list (paper 3.1.5). Calculators
//   1. clear the dead, and find which particles have left their domain;
//   2. agree on how far the action sees: an all-reduce of maxima, which also says whether one of them has failed;
//   3. send each domain within reach one message: migrants to their new owner, and ghosts of what it may see;
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
  std::size_t item = 0;  // index in that list
  std::size_t systems[2] = {};
  std::size_t count = 1;  // number of systems: two if they interact with each other
  std::uint64_t newborn_from[2] = {UINT64_MAX, UINT64_MAX};  // ids that meet for the first time
  Collided collided[2] = {};  // already in this sub-step
  bool collides_again[2] = {};  // and later in it
  std::uint32_t law = 0;  // number of the law among those of that list that remember, from 0 on
  std::uint32_t substep = 0;  // number of the sub-step since the run's start, from 1 on
  double time = 0;  // at its start, seconds of the animation
  float start = 0, end = 1;  // which part of the frame the sub-step is
  bool last = false;  // the frame's last sub-step
};

/// Calculators, collective. Returns false where one of them has failed: all leave the list and go on to the report.
bool interact(Rank& rank, const Script& script, Calculator& calculator, const Round& round,
              const Interaction& interaction);

/// Tells the other calculators, at their first interaction, that this one failed before the list.
void say_failed(Rank& rank, const Round& round);

}  // namespace motes::engine
