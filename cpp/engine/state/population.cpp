#include "engine/state/population.h"

#include <numeric>
#include <utility>

#include "simd/float_mode.h"

namespace motes::engine {

std::vector<std::uint32_t> first_indices(std::size_t count) {
  std::vector<std::uint32_t> indices(count);
  std::iota(indices.begin(), indices.end(), 0u);
  return indices;
}

std::vector<std::uint8_t> collided_of(const Population& here) {
  std::vector<std::uint8_t> collided(here.store.size());
  for (std::size_t i = 0; i < collided.size(); ++i) collided[i] = here.collided.contains(here.store.ids()[i]) ? 1 : 0;
  return collided;
}

void note_collided(Population& here, const std::vector<std::uint8_t>* chosen) {
  if (chosen == nullptr) return here.collided.clear();
  for (std::size_t i = 0; i < chosen->size(); ++i) {
    if ((*chosen)[i] != 0) here.collided.insert(here.store.ids()[i]);
  }
}

void start_frame(Population& here) {
  here.preview.reset();
  here.moved = false;
  here.counts_afresh = true;
  here.outcome.clear();
  here.bounced.clear();
  here.collided.clear();
  here.interaction = {};
  here.walls.clear();
  here.tally = {};
  here.tally.at_start = here.store.size();
  here.ways.fill(Handling::kUnknown);
  here.sent.clear();
  here.events.clear();
}

void begin_counts(Population& here) {
  if (!std::exchange(here.counts_afresh, false)) return;
  for (const int attribute : {particles::hit, particles::hit_normal, particles::landing}) here.store.forget(attribute);
}

void keep_copies(System& system, Population& here) {
  if (system.keeps_copies) return;
  system.keeps_copies = true;
  const simd::FloatMode mode;
  system.history.restore_copies(here.store, system.key);
  if (here.preview) here.preview->history.restore_copies(here.preview->store, system.key);
}

}  // namespace motes::engine
