// Costs of work on a simulated machine. Under a cluster simulator particles are really computed, but these costs
// determine the time; elsewhere all costs are 0 and unused.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "actions/action.h"
#include "comm/communicator.h"
#include "recording/record.h"

namespace motes::engine {

/// Nanoseconds on a machine of speed 1; per particle unless said otherwise.
struct Costs {
  std::array<double, actions::kKinds> act{};  // calculator: one action on a particle
  double birth = 0;    // manager: create a particle, find its owner, pack it
  double newborn = 0;  // calculator: add a newborn to its system and run the list for it
  double share = 0;    // calculator that creates births: create a particle, find its owner, sort its number
  double forward = 0;  // calculator: forward the number of a birth
  double make = 0;     // calculator: create one of its own newborns from its number
  double leave = 0;    // calculator: remove a migrant from its system and pack it
  double gap = 0;      // calculator: per migrant and particle of its system (later particles move up)
  double arrive = 0;   // calculator: unpack a migrant and add it to its system
  double copy = 0;     // calculator, in an interaction: pack a ghost, or unpack one and put it into a cell
  double select = 0;   // donor: per particle of the system for which it looks for a cut
  double record = 0;   // calculator: project a particle and pack its record
  double collect = 0;  // image generator: receive a record
  double draw = 0;     // image generator: draw a record
  double picture = 0;  // image generator: a whole picture without particles
  double report = 0;   // any rank: read the report of one child, per system
  double report_byte = 0;  // any rank except the manager: forward one byte of loads
  /// `messages.message`: the cost of a message at each end; `messages.byte`: in addition, per byte. If `byte` is above
  /// 0, messages do not compete for links. `messages.scale`: how many particles each computed one stands for.
  comm::Weights messages;

  /// Returns the cost of a list's actions on one particle in one sub-step, ns.
  double of(const std::vector<recording::Item>& list) const;

  bool operator==(const Costs&) const = default;
};

/// Reads lines `name = number`; # starts a comment. Names are the fields of Costs and `action.NAME`; `action` without a
/// name is the cost of all kinds that are not listed. Throws std::invalid_argument, naming the line.
Costs read_costs(const std::string& text);

}  // namespace motes::engine
