// exchange (paper 3.2.4): migrants go directly to their new owners, those of all systems in one message.
#pragma once

#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

void send_migrants(Rank& rank, const Script& script, const Calculator& calculator, Round& round);
void receive_arrivals(Rank& rank, const Script& script, Calculator& calculator, const Round& round);

}  // namespace motes::engine
