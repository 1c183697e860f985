#include "particles/wrap.h"

#include <algorithm>

#include "simd/float_mode.h"

namespace motes::particles {

namespace {

constexpr std::size_t kWrappedTogether = 64 * kBlock;

// Returns whether no position needs wrapping, as in most blocks. The loop has no branches.
bool all_inside(const Period& period, std::size_t count, const float* position) {
  unsigned outside = 0;
  for (std::size_t i = 0; i < count; ++i) outside |= static_cast<unsigned>(!period.holds(position[i]));
  return outside == 0;
}

}  // namespace

void wrap(const Period& period, std::size_t count, float* position, float* crossings) {
  for (std::size_t first = 0; first < count; first += kBlock) {
    const std::size_t length = std::min(kBlock, count - first);
    if (all_inside(period, length, position + first)) continue;
    for (std::size_t i = first; i < first + length; ++i) {
      const Wrapped wrapped = period.wrapped(position[i]);
      position[i] = wrapped.at;
      if (wrapped.crossed != 0) crossings[i] += wrapped.crossed;
    }
  }
}

void wrap(Store& store, threads::Pool& pool) {
  const Periods& periods = store.schema().periods();
  if (!periods.any() || store.size() == 0) return;
  for (int axis = 0; axis < 3; ++axis) {
    if (!periods.has(axis)) continue;
    float* const position = store.writable_plane(particles::position, axis);
    float* const crossings = store.writable_plane(store.schema().crossings(), axis);
    threads::over_ranges(pool, store.size(), kWrappedTogether, [&](std::size_t first, std::size_t last) {
      const simd::FloatMode mode;
      wrap(periods[axis], last - first, position + first, crossings + first);
    });
  }
}

}  // namespace motes::particles
