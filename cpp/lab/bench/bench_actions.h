// Measures what each action costs, alone and added to a list that runs anyway.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "particles/blocks.h"

namespace motes::bench {

/// Nanoseconds per particle and step on one core. `alone` is the minimum of the repeats, since everything else on the
/// machine can only add time; `added` is the median of comparisons. "In cache": kCached particles over many sub-steps,
/// whose columns stay in the first-level cache, so that only arithmetic is left; sort, which does not work on blocks,
/// uses kSorted particles.
struct ActionCost {
  std::string action;
  double alone = 0;           // a list of this action only
  double added = 0;           // the fountain's list (paper 5.2) with it, minus the list without it
  double memory_limit = 0;    // loads and stores of the columns that it reads and writes, without the ids
  double alone_in_cache = 0;
  double added_in_cache = 0;
  int bytes_loaded = 0;       // per particle
  int bytes_stored = 0;
};

/// Particles in the small stores.
inline constexpr std::size_t kCached = 512, kSorted = 8192;

/// Measures all actions but those between particles, in the order of actions::Kind and with ordinary parameters: some
/// particles are inside the shapes that push, none in those that kill, and hardly any hit a surface in the step. Throws
/// std::invalid_argument for counts below 1.
std::vector<ActionCost> action_bench(std::size_t particles, int repeats);

/// Times of four lists on the same columns: the fountain's five actions, these and seven more, and both without the
/// random acceleration. The lists run in turn and are compared within each turn: ratios are medians over turns.
struct ListBench {
  struct List {
    std::string name;
    double seconds = 0;  // per step, the median
    double in_cache = 0;  // seconds per step of kCached particles, scaled to the full number: its arithmetic
    double of_limit = 0;  // seconds of only loads and stores, divided by the list's
    double of_roofline = 0;  // the longer of these seconds and its arithmetic's, divided by the list's
  };
  std::vector<List> lists;
  double limit = 0;  // seconds of only loads and stores of position, velocity and age
  double ratio = 0;  // twelve / five
};
ListBench list_bench(std::size_t particles, int steps);

}  // namespace motes::bench
