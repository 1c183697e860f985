// What a newborn particle costs those that create it and send it to its owner: `python -m motes bench births`.
#pragma once

namespace motes::bench {

/// Nanoseconds per particle, each the median over repeats.
struct BirthBench {
  double make = 0;     // from its number: place and velocity drawn
  double own = 0;      // finding its owner
  double pack = 0;     // its number sorted into the messages of a step
  double forward = 0;  // that read from such messages and sorted again
  double take = 0;     // made again by its owner, behind the particles of its system
  double run = 0;      // snow's list, over the newborn alone
};

/// One of `calculators` that makes `births` of snow, all over their domains, `repeats` times. Throws
/// std::invalid_argument where a number is not positive.
BirthBench birth_bench(int calculators, int births, int repeats);

}  // namespace motes::bench
