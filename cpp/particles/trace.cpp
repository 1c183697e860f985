#include "particles/trace.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simd/float_mode.h"

namespace motes::particles {

namespace {

constexpr std::size_t kTracedTogether = 64 * kBlock;
constexpr double kMostEvery = 1e15;

using Planes = std::array<float*, 3>;

Planes writable(Store& store, int attribute) {
  return {store.writable_plane(attribute, 0), store.writable_plane(attribute, 1), store.writable_plane(attribute, 2)};
}

// Moves the kept positions of particles that have wrapped along one axis.
struct Wrapping {
  float* crossings;  // now
  float* seen;       // at the last update of the trace
  std::array<float*, kTraced> kept;  // null: no particle has a position there
  double length;

  void follow(const float* count, std::size_t first, std::size_t last) const {
    for (std::size_t i = first; i < last; ++i) {
      const float crossed = crossings[i] - seen[i];
      if (crossed == 0) continue;
      seen[i] = crossings[i];
      if (!(count[i] > 0)) continue;
      for (float* const plane : kept) {
        if (plane != nullptr)
          plane[i] = static_cast<float>(static_cast<double>(plane[i]) - length * static_cast<double>(crossed));
      }
    }
  }
};

void follow_wraps(Store& store, int first_slot, const float* count, threads::Pool& pool) {
  const Schema& schema = store.schema();
  const int seen = schema.find(kTraceCrossings);
  if (seen < 0 || !schema.periods().any()) return;
  for (int axis = 0; axis < 3; ++axis) {
    if (!schema.periods().has(axis)) continue;
    Wrapping wrapping{store.writable_plane(schema.crossings(), axis),
                      store.writable_plane(seen, axis),
                      {},
                      schema.periods()[axis].length()};
    for (int slot = 0; slot < kTraced; ++slot) {
      const bool used = !store.uniform(first_slot + slot);
      wrapping.kept[static_cast<std::size_t>(slot)] = used ? store.writable_plane(first_slot + slot, axis) : nullptr;
    }
    threads::over_ranges(pool, store.size(), kTracedTogether, [&](std::size_t first, std::size_t last) {
      const simd::FloatMode mode;
      wrapping.follow(count, first, last);
    });
  }
}

}  // namespace

std::vector<std::pair<std::string, int>> trace_attributes(bool periodic) {
  std::vector<std::pair<std::string, int>> all{{kTraceCount, 1}};
  for (int slot = 0; slot < kTraced; ++slot) all.emplace_back("ribbon_" + std::to_string(slot), 3);
  if (periodic) all.emplace_back(kTraceCrossings, 3);
  return all;
}

TraceTimes TraceTimes::over(double length, double dt, std::uint64_t frame) {
  // The oldest position is at least kTraced - 1 intervals old. A length of whole frames may be rounded upwards.
  const double frames = std::ceil(length / dt / (kTraced - 1) - 1e-6);
  return {frame, static_cast<std::uint64_t>(std::clamp(frames, 1.0, kMostEvery))};
}

void keep_trace(Store& store, const TraceTimes& times, threads::Pool& pool) {
  const int counts = store.schema().find(kTraceCount);
  if (counts < 0 || store.size() == 0 || store.uniform(position)) return;
  float* const count = store.writable_plane(counts, 0);
  const int first_slot = counts + 1;
  follow_wraps(store, first_slot, count, pool);
  const bool all = times.now();
  if (!all && std::all_of(count, count + store.size(), [](float kept) { return kept > 0; })) return;
  const Planes to = writable(store, first_slot + times.slot(0));
  const Planes from = writable(store, position);
  threads::over_ranges(pool, store.size(), kTracedTogether, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (!all && count[i] > 0) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) to[axis][i] = from[axis][i];
      count[i] = std::min(count[i] + 1, static_cast<float>(kTraced));
    }
  });
}

}  // namespace motes::particles
