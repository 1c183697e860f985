// create (paper 3.2.1): the manager counts, numbers and makes the births of the frame and deals them out by domain; its
// message is also the notice that transmission has ended, and says what it was asked to do. share.h is another way: the
// calculators make births.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/parts/manager.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// A calculator's part of a round's births.
struct Newborn {
  Heard heard;  // the manager's message
  std::optional<RenderPlan> plan;  // plan of the frame's picture, with the first round
  base::Reader dealt{{}};  // births where the manager makes them
  bool interact = false;  // particles of the round meet
  bool compare = false;  // neighbours compare their loads
  bool shared = false;  // the calculators made them:
  std::vector<comm::Message> shares;  // messages from several ranks, each with numbers of births by group, in order
  std::vector<base::Reader> readers;  // readers of `shares`
  std::uint32_t group = 0;  // the next to be taken
  std::uint64_t count = 0;  // particles in all of it
};

/// Manager: makes and deals out a round's births, with the cuts that others do not know yet.
void deal(Rank& rank, Script& script, Manager& manager, const Round& round);

/// Receives the manager's message of a round. If this rank's list differs it fails, but follows the manager's rounds
/// until all agree on that. Collective.
Newborn receive_births(Rank& rank, Script& script, Calculator& calculator, std::size_t round);

/// Calculator: takes its particles of the next group into the store.
void take_births(const Rank& rank, const System& system, const BirthGroup& group, Newborn& newborn,
                 particles::Store& store);

/// Makes what belongs to this calculator of a group, where all ranks do so.
void create_own(const Rank& rank, const System& system, const BirthGroup& group, particles::Store& store);

/// space "fit": the first births decide where the domains lie. Returns whether they did.
bool fit(const Rank& rank, Script& script, std::size_t system);

/// Makes particles first .. last - 1 of a group, by their numbers in it, piece by piece.
void make_births(const Rank& rank, const System& system, const BirthGroup& group, std::uint64_t first,
                 std::uint64_t last, const std::function<void(const particles::Store&)>& use);
/// Makes those with these numbers, in this order.
void make_births(const Rank& rank, const System& system, const BirthGroup& group,
                 std::span<const std::uint32_t> numbers, const std::function<void(const particles::Store&)>& use);

}  // namespace motes::engine
