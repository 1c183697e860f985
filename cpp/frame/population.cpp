#include "frame/population.h"

#include <numeric>

#include "simd/float_mode.h"

namespace motes::frame {

std::vector<std::uint32_t> first_indices(std::size_t count) {
  std::vector<std::uint32_t> indices(count);
  std::iota(indices.begin(), indices.end(), 0u);
  return indices;
}

void start_frame(Population& here) {
  here.preview.reset();
  here.moved = false;
  here.outcome.clear();
  here.bounced.clear();
  here.sight = {};
  here.tally = {};
  here.tally.at_start = here.store.size();
  here.sent.clear();
  here.events.clear();
}

void keep_copies(System& system, Population& here) {
  if (system.keeps_copies) return;
  system.keeps_copies = true;
  const simd::FloatMode mode;
  system.history.restore_copies(here.store, system.key);
}

}  // namespace motes::frame
