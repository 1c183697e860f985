// Disasters by the thousand: stories played by simulated ranks that die, all at once or one by one, and the results
// that they must give nevertheless. One seed is one disaster, the same each time.
#pragma once

#include <cstdint>
#include <string>

namespace motes::soak {

struct Disaster {
  enum class Kind : std::uint8_t { orders, losses, restarts };
  Kind kind = Kind::orders;
  int ranks = 0;           // at the start
  int died = 0;            // ranks, or jobs
  int survived = 0;        // losses after which the run continued; restarts
  bool reported = false;   // the run ended and reported why
  std::string broken;      // the promise that was broken; empty: none
};

/// Plays one disaster and checks the promises: each frame has the particles and the picture of an undisturbed run; a
/// run ends early only with a message, and never because of the loss of a single rank; no rank waits forever; a damaged
/// checkpoint is never used.
Disaster disaster(std::uint64_t seed);

}  // namespace motes::soak
