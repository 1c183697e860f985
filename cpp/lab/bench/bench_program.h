// Measures how fast one core runs a recorded list, compared with the limit of its memory.
#pragma once

#include <cstddef>
#include <string>

namespace motes::bench {

struct ActBench {
  double updates_per_s = 0;               // particle steps per second; finds the dead and the migrants too
  double memory_limit_updates_per_s = 0;  // only loads and stores of position, velocity and age
  double ratio = 0;                       // median over steps of limit seconds / step seconds, measured in turn
  double bytes_per_particle = 0;
};

/// Runs the paper's snow (5.1) or fountain (5.2) list on `particles` particles, `steps` times, on this core. Throws
/// std::invalid_argument unless `scene` is "snow" or "fountain".
ActBench act_bench(const std::string& scene, std::size_t particles, int steps);

/// Four ways to find the particles that left a domain, in seconds per step for `particles` particles.
struct LeaverBench {
  double none = 0;  // only the list
  double fused = 0;  // tested in the same pass, while the block is in the first-level cache (what the engine does)
  double scanned = 0;  // a separate pass over the positions afterwards
  double binned = 0;  // the paper's sub-domains (section 4): each bin is a vector, kept sorted; the edge bins are
                      // searched for migrants, all bins for particles that changed bin
};
LeaverBench leaver_bench(std::size_t particles, int bins, int steps);

}  // namespace motes::bench
