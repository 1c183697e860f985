// Disasters by the thousand: stories played by simulated ranks that die, all at once or one by one, and what must come
// out nevertheless. One seed is one disaster, the same each time.
#pragma once

#include <cstdint>
#include <string>

namespace motes::soak {

struct Disaster {
  enum class Kind : std::uint8_t { orders, losses, restarts };
  Kind kind = Kind::orders;
  int ranks = 0;           // at the start
  int died = 0;            // ranks, or jobs
  int survived = 0;        // losses behind which the run went on; restarts
  bool told = false;       // the run ended, and said why
  std::string broken;      // which promise was not kept; empty: none
};

/// The promises: whatever happens, each frame has the particles and the picture of the run to which nothing happened;
/// a run ends before its end only where a sentence says why, and never because one rank alone was lost; nobody waits
/// for ever; a checkpoint that is damaged is never used.
Disaster disaster(std::uint64_t seed);

}  // namespace motes::soak
