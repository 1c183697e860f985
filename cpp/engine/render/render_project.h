// render on calculators: turns particles into records and sends these to the ranks that draw them.
#pragma once

#include "engine/render/render.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Makes the records of this calculator's particles.
void project(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter);

/// Sends each rank the records of its tiles; on path composite, partial tiles in place of the records that can be
/// merged. If this rank has failed, sends the failure to each drawing rank.
void send_records(Rank& rank, Painter& painter);

/// Reads the records of a message from send_records(): calls `add(bytes)` for each batch.
template <class Add>
void take_records(base::Reader& in, const Add& add) {
  for (auto systems = in.get<std::uint32_t>(); systems > 0; --systems) add(in.take(in.get<std::uint64_t>()));
}

/// Returns a message with a failure, in place of a rank's part of the picture.
comm::Message failure_message(int failed_rank, const Failure& failure);

/// Gives up because of the failure in a message from failure_message().
[[noreturn]] void give_up_for(Rank& rank, const comm::Message& message);

}  // namespace motes::engine
