// create (paper 3.2.1): the manager counts, numbers and creates the births of the frame and deals them out by domain.
// Its message also marks the end of transmission, and carries the hash of its list. Alternatively, calculators create
// births (share.h).
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
  ManagerMessage from_manager;  // the manager's message
  std::optional<RenderPlan> plan;  // plan of the frame's picture, only in the first round
  base::Reader dealt{{}};  // births that the manager created
  bool interact = false;  // the round has pair interactions
  bool compare = false;  // neighbours compare their loads
  bool shared = false;  // calculators create the births; the next three members apply
  std::vector<comm::Message> shares;  // messages from several ranks, each with numbers of births by group, in order
  std::vector<base::Reader> readers;  // readers of `shares`
  std::uint32_t group = 0;  // the next group to take
  std::uint64_t count = 0;  // number of particles
};

/// Manager: creates and deals out a round's births, together with cuts that have not been sent yet.
void deal(Rank& rank, Script& script, Manager& manager, const Round& round);

/// Receives the manager's message of a round. If this rank's list differs, the rank fails, but follows the manager's
/// rounds until all ranks agree on the failure. Collective.
Newborn receive_births(Rank& rank, Script& script, Calculator& calculator, std::size_t round);

/// Calculator: adds its particles of the next group to the store.
void take_births(const Rank& rank, const System& system, const BirthGroup& group, Newborn& newborn,
                 particles::Store& store);

/// Creates a group's particles that this calculator owns, without messages: every rank creates the whole group and
/// drops the rest.
void create_own(const Rank& rank, const System& system, const BirthGroup& group, particles::Store& store);

/// Fits the domains of a system with space "fit" to its first births. Returns whether it did.
bool fit(const Rank& rank, Script& script, std::size_t system);

/// Creates particles first .. last - 1 of a group, and calls `use` with each piece.
void make_births(const Rank& rank, const System& system, const BirthGroup& group, std::uint64_t first,
                 std::uint64_t last, const std::function<void(const particles::Store&)>& use);
/// Creates the particles of a group with these numbers, in this order, and calls `use` with each piece.
void make_births(const Rank& rank, const System& system, const BirthGroup& group,
                 std::span<const std::uint32_t> numbers, const std::function<void(const particles::Store&)>& use);

}  // namespace motes::engine
