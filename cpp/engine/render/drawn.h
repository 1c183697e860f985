// What a system contributes to a picture.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/state/script.h"
#include "image/project/projector.h"
#include "image/scene.h"
#include "particles/store.h"

namespace motes::engine {

/// The columns that a picture shows. They point into the store.
image::Drawn drawn(const particles::Store& store);

/// `count` of them, from the first one on.
image::Drawn part_of(const image::Drawn& all, std::size_t first, std::size_t count);

/// Computes the numbers of tiles of particles first .. first + count - 1 (first: a multiple of 16) at a time of the
/// animation, s. Returns a plane of them in `memory`; null where the pick has no expression.
const float* tile_numbers(const image::Pick& pick, particles::Store& store, std::size_t first, std::size_t count,
                          double time, std::vector<float>& memory);

/// Returns how records of a system are made, if the current record has a view; equal on every rank.
image::Projection projection(const Script& script, std::size_t system);

}  // namespace motes::engine
