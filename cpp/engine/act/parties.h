// The participants of a pair interaction on this calculator.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

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

  std::size_t count() const { return interaction.meeting.count; }
  /// Returns the index of a side's system.
  std::size_t number(std::size_t side) const { return interaction.meeting.sides[side].system; }
  const System& system(std::size_t side) const { return *script.systems[number(side)]; }
  Population& population(std::size_t side) const { return *calculator.populations[number(side)]; }
  /// Returns the key of a side's neighbour list and ghosts, if they are kept.
  std::pair<std::size_t, std::uint32_t> key(std::size_t side) const {
    return {number(side), interaction.meeting.sides[side].kept.law};
  }

  /// Returns the side whose particles see those of this side: itself, or the other system.
  std::size_t seer(std::size_t side) const { return count() == 1 ? 0 : 1 - side; }

  /// Runs work that may fail, and splits its time between the systems by their numbers of particles.
  template <class Work>
  void compute(const Work& work) const {
    rank.session.work("interact", [&] {
      const double spent = rank.machine.timed([&] { of_item(system(0).list, number(0), interaction.item, work); });
      double all = 0;
      for (std::size_t side = 0; side < count(); ++side) all += static_cast<double>(population(side).store.size());
      for (std::size_t side = 0; side < count(); ++side) {
        const auto own = static_cast<double>(population(side).store.size());
        population(side).tally.compute_s += spent * (all > 0 ? own / all : 1 / static_cast<double>(count()));
      }
    });
  }
};

}  // namespace motes::engine
