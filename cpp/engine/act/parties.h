// The participants of a pair interaction on this calculator.
#pragma once

#include <cstddef>

#include "engine/act/interact.h"
#include "engine/session/item_failure.h"
#include "engine/session/rank.h"
#include "engine/session/round.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// One system, or two systems that see each other, as sides 0 and 1.
struct Parties {
  Rank& rank;
  const Script& script;
  Calculator& calculator;
  const Round& round;
  const Interaction& interaction;

  const System& system(std::size_t side) const { return *script.systems[interaction.systems[side]]; }
  Population& population(std::size_t side) const { return *calculator.populations[interaction.systems[side]]; }

  /// Returns the action as it acts on the particles of a side.
  const actions::Action& action(std::size_t side) const {
    return side == 1 && interaction.counterpart != nullptr ? *interaction.counterpart : *interaction.action;
  }

  /// Returns a side's number in a contact of two systems (interactions::Side::place).
  int place(std::size_t side) const { return interaction.counterpart != nullptr ? static_cast<int>(side) + 1 : 0; }

  /// Returns the side whose particles see those of this side: itself, or the other system.
  std::size_t seer(std::size_t side) const { return interaction.count == 1 ? 0 : 1 - side; }

  /// Runs work that may fail, and splits its time between the systems by their numbers of particles.
  template <class Work>
  void compute(const Work& work) const {
    rank.session.work("interact", [&] {
      const double spent =
          rank.machine.timed([&] { of_item(system(0).list, interaction.systems[0], interaction.item, work); });
      double all = 0;
      for (std::size_t side = 0; side < interaction.count; ++side)
        all += static_cast<double>(population(side).store.size());
      for (std::size_t side = 0; side < interaction.count; ++side) {
        const auto own = static_cast<double>(population(side).store.size());
        population(side).tally.compute_s += spent * (all > 0 ? own / all : 1 / static_cast<double>(interaction.count));
      }
    });
  }
};

}  // namespace motes::engine
