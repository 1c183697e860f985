// Everything that a rank holds. Each phase takes the parts that it uses.
#pragma once

#include "engine/parts/manager.h"
#include "engine/render/render.h"
#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

struct Parts {
  explicit Parts(std::unique_ptr<comm::Communicator> communicator, roles::Cast cast, Settings settings)
      : rank(std::move(communicator), std::move(cast), std::move(settings)) {}

  Rank rank;              // settings, session, threads, clocks
  Script script;          // what was recorded; the same on all ranks
  Calculator calculator;  // the particles of this rank
  Manager manager;        // cuts, loads and the account; used only on the manager
  Painter painter;        // projecting and drawing
};

}  // namespace motes::engine
