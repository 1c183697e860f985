// render, a calculator's side: particles become records, and records go to the ranks that draw them.
#pragma once

#include "engine/render/render.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Makes the records of this calculator's particles.
void project(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter);

/// Sends each rank the records of its tiles; on path composite, partial tiles in place of those records that can be
/// merged. Where projecting has failed, each rank that draws is told why.
void send_records(Rank& rank, Painter& painter);

/// Takes the records of such a message, `add(bytes)` for each system.
template <class Add>
void take_records(base::Reader& in, const Add& add) {
  for (auto systems = in.get<std::uint32_t>(); systems > 0; --systems) add(in.take(in.get<std::uint64_t>()));
}

/// Returns a message that says why this rank's part, or another's that it needed, is missing.
comm::Message failure_message(int failed_rank, const Failure& failure);

/// Gives up, for the reason that a message of this kind gives.
[[noreturn]] void give_up_for(Rank& rank, const comm::Message& message);

}  // namespace motes::engine
