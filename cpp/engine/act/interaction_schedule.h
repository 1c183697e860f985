// Lists with interactions: all particles go through them in step, since they see each other on the way.
#pragma once

#include "engine/act/interact.h"
#include "engine/births/create.h"
#include "engine/session/rank.h"
#include "engine/session/round.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Calculators, collective: runs the lists of the round's systems in which particles meet, sub-step by sub-step.
/// `newborn`: what they got of the round's births; taken from it where the systems before them have taken theirs.
class InteractionSchedule {
 public:
  InteractionSchedule(Rank& rank, const Script& script, Calculator& calculator, const Round& round);

  /// Takes a system's births out of the round's; they join the others where the list says so.
  void take_births(std::size_t system, Newborn& newborn);

  /// Runs the lists of all systems whose births were taken. Where a rank fails, all leave together.
  void run();

 private:
  struct Runner {
    std::size_t system;
    std::vector<ListSegment> segments;
    std::vector<particles::Store> births;  // one per group
    std::size_t next_group = 0;
    std::size_t next_segment = 0;
    std::uint64_t newborn_from = 0;  // ids from here on have met nobody
    Collided collided = Collided::none;  // collisions of this sub-step
    std::uint32_t laws = 0;              // laws with kept lists that have acted in this sub-step
  };

  bool run_substep(int substep);
  /// Runs the list to the next pair interaction and returns it, or to the end and returns null.
  const ListSegment* run_to_interaction(Runner& runner, int substep);
  void run_segment(Runner& runner, const ListSegment& segment, int substep);
  Interaction interaction_of(const ListSegment& segment, Runner& first, Runner& second, int substep) const;
  std::size_t partner_of(const Runner& runner, const ListSegment& segment) const;

  Rank& rank_;
  const Script& script_;
  Calculator& calculator_;
  const Round& round_;
  std::vector<Runner> runners_;
};

}  // namespace motes::engine
