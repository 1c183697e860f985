// Measures the cost of a newborn particle for the calculators that create it and send it to its owner: `python -m motes
// bench births`.
#pragma once

namespace motes::bench {

/// Nanoseconds per particle, each the median over repeats.
struct BirthBench {
  double make = 0;  // create it from its number: draw position and velocity
  double own = 0;  // find its owner
  double pack = 0;  // sort its number into the messages of a step
  double forward = 0;  // read the number from such messages and sort it again
  double take = 0;  // create it again on its owner, behind the particles of its system
  double run = 0;  // run snow's list over only the newborn
};

/// Measures one of `calculators` calculators that creates `births` snowflakes all over the domains, `repeats` times.
/// Throws std::invalid_argument if a number is not positive.
BirthBench birth_bench(int calculators, int births, int repeats);

}  // namespace motes::bench
