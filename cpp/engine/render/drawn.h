// What a system contributes to a picture.
#pragma once

#include "engine/state/script.h"
#include "image/project/projector.h"
#include "image/scene.h"
#include "particles/store.h"

namespace motes::engine {

/// The columns that a picture shows. They point into the store.
image::Drawn drawn(const particles::Store& store);

/// The same with the past positions of a system whose sprite asks for them.
image::Drawn drawn(const Script& script, std::size_t system, const particles::Store& store);

/// `count` of them, from the first one on.
image::Drawn part_of(const image::Drawn& all, std::size_t first, std::size_t count);

/// Returns how records of a system are made, if the current record has a view; equal on every rank.
image::Projection projection(const Script& script, std::size_t system);

}  // namespace motes::engine
