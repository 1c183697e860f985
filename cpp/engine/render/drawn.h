// What of a system goes into its picture, and what that depends on.
#pragma once

#include "engine/state/script.h"
#include "image/project/projector.h"
#include "image/scene.h"
#include "particles/store.h"

namespace motes::engine {

/// The columns that a picture shows. They point into the store.
image::Drawn drawn(const particles::Store& store);

/// `count` of them, from the first one on.
image::Drawn part_of(const image::Drawn& all, std::size_t first, std::size_t count);

/// How the records of a system are made, where the record under way has a view: equal on every rank.
image::Projection projection(const Script& script, std::size_t system);

}  // namespace motes::engine
