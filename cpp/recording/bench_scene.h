// What the benchmarks of recorded lists share: the air full of particles, the paper's lists, and what memory allows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "actions/action.h"
#include "particles/store.h"
#include "recording/births.h"

namespace motes::recording {

/// Seconds that this thread has had a core: what other processes do with it does not count.
double cpu_now();

/// The middle of the values, of which there must be one; the lower of two.
double median(std::vector<double> values);

/// The actions of the paper's snow (5.1) or fountain (5.2). Throws std::invalid_argument for another name.
std::vector<actions::Action> paper_list(const std::string& scene);

/// A burst of this many particles, evenly spread in a box 100 x 50 x 100 m above the ground, that fall slowly.
Birth full_air(std::size_t particles);

/// What a pass must do at least that reads and writes these attributes (a bit each): it loads all of their planes and
/// stores those that are written. The change keeps the compiler honest.
void touch(particles::Store& store, std::uint64_t reads, std::uint64_t writes);

}  // namespace motes::recording
