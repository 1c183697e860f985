// Lists with interactions: all particles run them in lockstep, since they see each other at the interactions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/act/interact.h"
#include "engine/births/create.h"
#include "engine/session/rank.h"
#include "engine/session/round.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Runs the lists of a round's systems with interactions, sub-step by sub-step. Collective over calculators.
class InteractionSchedule {
 public:
  InteractionSchedule(Rank& rank, const Script& script, Calculator& calculator, const Round& round);

  /// Takes a system's births from `newborn`, in the order of systems; run() adds them at their places in the list.
  void take_births(std::size_t system, Newborn& newborn);

  /// Runs the lists of all systems whose births were taken. If a calculator fails, all of them stop at the next
  /// interaction.
  void run();

 private:
  struct Runner {
    std::size_t system;
    std::vector<ListSegment> segments;
    std::vector<particles::Store> births;  // one per group
    std::size_t next_group = 0;
    std::size_t next_segment = 0;
    const actions::Action* reached = nullptr;  // the interaction that the list has come to, until it runs
    std::uint64_t newborn_from = 0;      // ids from here on have not collided yet
    Collided collided = Collided::none;  // collisions of this sub-step
    std::uint32_t laws = 0;              // number of laws with kept lists that have acted in this sub-step
  };

  void start_substep();
  bool run_substep(int substep);
  std::optional<Interaction> next_interaction(Runner& runner, int substep);
  void run_to_interaction(Runner& runner, int substep);
  void run_segment(Runner& runner, const ListSegment& segment, int substep);
  interactions::SubStep step_of(int substep) const;
  Interaction interaction_of(Runner& first, Runner& second, int substep) const;
  void describe_collision(Runner& runner, std::size_t side, Interaction& interaction) const;
  Runner& partner_of(const Runner& runner);

  Rank& rank_;
  const Script& script_;
  Calculator& calculator_;
  const Round& round_;
  std::vector<Runner> runners_;
};

}  // namespace motes::engine
