// Checks which calculator has which particles.
#pragma once

#include "engine/engine.h"
#include "engine/state/places.h"
#include "support/check.h"

namespace test {

/// Checks that each calculator has exactly the particles that it owns, as it must between two frames.
inline void check_owners(motes::engine::Engine& engine) {
  for (int i = 0; engine.session().calculates() && i < engine.system_count(); ++i) {
    const motes::particles::Store& store = *engine.seen(i).store;
    const motes::domains::Places places = motes::engine::places_of(store);
    for (std::size_t p = 0; p < store.size(); ++p) {
      CHECK(motes::engine::owner_of(engine.system(i).domains, places, p) == engine.session().calculator());
    }
  }
}

}  // namespace test
