// Costs of work on a simulated machine. Under a cluster simulator particles are really computed, but time comes from
// here; elsewhere all costs are 0 and unused.
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
  std::array<double, actions::kKinds> act{};  // one action
  double birth = 0;    // manager: making, finding its owner, packing
  double newborn = 0;  // calculator: taking it into its system, running the list for it
  double share = 0;    // calculator that creates births: making, finding its owner, sorting its number
  double forward = 0;  // calculator: a birth's number that it passes on
  double make = 0;     // calculator: making its own by their numbers
  double leave = 0;    // calculator: taking a migrant out of its system, packing
  double gap = 0;  // calculator: a migrant, per particle of its system there (those behind it move up)
  double arrive = 0;  // calculator: unpacking, putting it into its system
  double copy = 0;    // calculator, in an interaction: packing a copy, or unpacking one and putting it into a cell
  double select = 0;  // donor: per particle of the system whose new cut it looks for
  double record = 0;  // calculator: projecting and packing for the image generator
  double collect = 0;  // image generator: receiving
  double draw = 0;  // image generator
  double picture = 0;  // image generator: a whole picture without particles
  double report = 0;  // any rank: what one rank right below it reports, per system
  double report_byte = 0;  // any rank but the manager: a byte of the loads that it passes on
  /// `messages.message`: any rank, a message at each of its ends; `messages.byte`: and a byte of it; where this is
  /// given, messages share no links. `messages.scale`: each computed particle stands for this many.
  comm::Weights messages;

  /// The cost of a list's actions on one particle in one sub-step.
  double of(const std::vector<recording::Item>& list) const;

  bool operator==(const Costs&) const = default;
};

/// Reads lines `name = number`; # starts a comment. Names are the fields above and `action.NAME`; `action` alone is the
/// cost of all kinds that are not named. Throws std::invalid_argument, naming the line.
Costs read_costs(const std::string& text);

}  // namespace motes::engine
