// After a loss: how far each rank that is left has come and what it holds, and what follows from that for all of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/recovery/replicas.h"

namespace motes::engine {

/// A generation that a rank holds.
struct Holding {
  GenerationId of;
  std::uint32_t parts = 0;  // calculators then
  std::int32_t own = -1;    // the calculators whose particles it has; -1: none
  std::int32_t other = -1;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Holding& holding) {
  visit(holding.of, holding.parts, holding.own, holding.other);
}

/// What a call brought to all ranks besides its result: signals and viewers' orders.
struct Announced {
  std::int32_t stop = 0;  // the signal after which all stop, or 0
  std::string orders;     // what viewers asked for
};

template <class Visitor>
constexpr void fields(Visitor& visit, Announced& announced) {
  visit(announced.stop, announced.orders);
}

/// What a rank tells the others after a loss.
struct Standing {
  std::uint64_t call = 0;          // the number of the collective call that was interrupted: others may be one ahead
  std::uint64_t frame = 0;         // frame of that call
  Announced announced;                     // announced in the call before
  std::uint64_t unsaved_from = UINT64_MAX;  // the first frame whose picture it needs again
  std::vector<Holding> holdings;
  std::vector<std::uint64_t> needs_script;  // frames that have run, and cannot be run again from their lists
  bool wrote = false;              // the script wrote to particles in the frame under way
  bool repeatable = true;          // the call before may be made once more
  std::string refusal;             // why this rank cannot go on, or empty
};

template <class Visitor>
constexpr void fields(Visitor& visit, Standing& standing) {
  visit(standing.call, standing.frame, standing.announced, standing.unsaved_from, standing.holdings,
        standing.needs_script, standing.wrote, standing.repeatable, standing.refusal);
}

/// What all ranks do to recover.
struct WayBack {
  std::uint64_t call = 0;   // call to repeat; ranks that were ahead have made it already
  std::uint64_t frame = 0;  // frame of that call
  bool anyone_ahead = false;  // some rank has made it before
  Announced announced;              // announced to those ranks in it
  GenerationId from;            // the generation from which the world is made again
  std::uint64_t unsaved_from = UINT64_MAX;
  std::vector<int> holders;  // the rank that has each calculator's particles; none where there were no particles yet
  std::string refusal;      // why there is no way back, or empty: a sentence
};

/// Chooses the newest generation that is complete and old enough; gives the same result on all ranks.
WayBack way_back(const std::vector<Standing>& standings);

}  // namespace motes::engine
