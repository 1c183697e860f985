// The positions of a store's particles in the form that domains take.
#pragma once

#include "domains/domains.h"
#include "particles/schema.h"
#include "particles/store.h"

namespace motes::engine {

/// Returns the positions and ids of all particles; valid as long as the store's planes are. Births write positions, so
/// a store with particles has those planes.
inline domains::Places places_of(const particles::Store& store) {
  domains::Places places;
  for (int axis = 0; axis < 3; ++axis) {
    places.position[static_cast<std::size_t>(axis)] = store.plane(particles::position, axis);
  }
  places.ids = store.ids();
  places.count = store.size();
  return places;
}

/// Returns the owner of particle `p`.
inline int owner_of(const domains::Domains& domains, const domains::Places& places, std::size_t p) {
  return domains.owner_of({places.position[0][p], places.position[1][p], places.position[2][p]}, places.ids[p]);
}

}  // namespace motes::engine
