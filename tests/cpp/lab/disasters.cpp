// Runs simulated disasters (soak/disasters.h) until one breaks a promise: `disasters SEEDS`. Exits with 1 and names it,
// or with 0.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "lab/soak/disasters.h"

int main(int count, char** arguments) {
  const std::uint64_t seeds = count > 1 ? std::strtoull(arguments[1], nullptr, 10) : 1000;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const motes::soak::Disaster disaster = motes::soak::disaster(seed);
    if (disaster.broken.empty()) continue;
    std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed), disaster.broken.c_str());
    return 1;
  }
  std::printf("%llu seeds, none broken\n", static_cast<unsigned long long>(seeds));
  return 0;
}
