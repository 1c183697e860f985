#include "frame/population.h"

#include <numeric>

#include "simd/float_mode.h"

namespace motes::frame {

particles::Store copy_of(const particles::Store& store) {
  std::vector<std::uint32_t> everyone(store.size());
  std::iota(everyone.begin(), everyone.end(), 0u);
  particles::Bytes bytes;
  store.pack(everyone, bytes);
  particles::Store copy(store.schema());
  particles::Reader in(bytes.view());
  copy.unpack(in);
  return copy;
}

void start_frame(Population& here) {
  here.preview.reset();
  here.moved = false;
  here.outcome.clear();
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
