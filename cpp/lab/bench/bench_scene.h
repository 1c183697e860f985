// Helpers of the benchmarks of recorded lists: a box full of particles, the paper's lists, and the memory's limit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "actions/action.h"
#include "particles/store.h"
#include "recording/births.h"

namespace motes::bench {

/// The attributes that a step of the simplest list reads and writes, one bit each.
inline constexpr std::uint64_t kStepped = 1u << particles::position | 1u << particles::velocity | 1u << particles::age;

/// Values behind the last one of a plane: vectors read past the end.
inline constexpr std::size_t kPadding = 16;

/// Returns seconds of CPU time of this thread, to which the work of other processes does not add.
double cpu_now();
inline double cpu_now_ms() { return cpu_now() * 1e3; }

/// Returns the median of at least one value; the lower middle one of an even number.
double median(std::vector<double> values);

/// Returns the actions of the paper's snow (5.1) or fountain (5.2). Throws std::invalid_argument for another name.
std::vector<actions::Action> paper_list(const std::string& scene);

/// Returns a burst of this many slowly falling particles, evenly spread in a box 100 x 50 x 100 m above the ground.
recording::Birth full_air(std::size_t particles);

/// Does the minimum work of a pass that reads and writes these attributes (one bit each): loads all of their planes and
/// stores those that are written. Changes the values so that the compiler cannot remove the work.
void touch(particles::Store& store, std::uint64_t reads, std::uint64_t writes);

}  // namespace motes::bench
