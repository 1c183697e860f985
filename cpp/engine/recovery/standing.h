// After a loss: the progress and replicas of each remaining rank, and the recovery that follows from them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/recovery/replicas.h"

namespace motes::engine {

/// A generation that a rank holds.
struct Holding {
  GenerationId of;
  std::uint32_t parts = 0;  // number of calculators in that generation
  std::int32_t own = -1;    // the calculator that the rank was; -1: none
  std::int32_t other = -1;  // the calculator whose replica it holds; -1: none
};

template <class Visitor>
constexpr void fields(Visitor& visit, Holding& holding) {
  visit(holding.of, holding.parts, holding.own, holding.other);
}

/// The signals and viewers' orders that a call sent to all ranks.
struct Announced {
  std::int32_t stop = 0;  // the signal that stops all ranks, or 0
  std::string orders;     // viewers' orders
};

template <class Visitor>
constexpr void fields(Visitor& visit, Announced& announced) {
  visit(announced.stop, announced.orders);
}

/// What a rank sends to the others after a loss.
struct Standing {
  std::uint64_t call = 0;          // number of the interrupted collective call; other ranks may be one ahead
  std::uint64_t frame = 0;         // frame of that call
  Announced announced;                     // from the previous call
  std::uint64_t unsaved_from = UINT64_MAX;  // the first frame whose picture it needs again
  std::vector<Holding> holdings;
  std::vector<std::uint64_t> needs_script;  // past frames that cannot run again from their lists
  bool wrote = false;              // the script wrote to particles in the current frame
  bool repeatable = true;          // the previous call can be repeated
  std::string refusal;             // why this rank cannot continue, or empty
};

template <class Visitor>
constexpr void fields(Visitor& visit, Standing& standing) {
  visit(standing.call, standing.frame, standing.announced, standing.unsaved_from, standing.holdings,
        standing.needs_script, standing.wrote, standing.repeatable, standing.refusal);
}

/// The plan that all ranks follow to recover.
struct WayBack {
  std::uint64_t call = 0;   // the call to repeat; ranks that were ahead have completed it already
  std::uint64_t frame = 0;  // frame of that call
  bool anyone_ahead = false;  // some ranks have completed it
  Announced announced;              // what those ranks received in it
  GenerationId from;            // the generation to restore the world from
  std::uint64_t unsaved_from = UINT64_MAX;
  std::vector<int> holders;  // the rank that holds each calculator's particles; empty if there were no particles yet
  std::string refusal;      // why recovery is impossible, as a clause; or empty
};

/// Chooses the newest generation that is complete and old enough; gives the same result on all ranks.
WayBack way_back(const std::vector<Standing>& standings);

}  // namespace motes::engine
