#include "program/events.h"

#include <algorithm>
#include <cmath>

#include "program/select.h"
#include "simd/float_mode.h"

namespace motes::program {
namespace {

using particles::Store;
using recording::Event;
using recording::Spawn;

// A child of a non-finite parent would not be finite either: it would die at once and create children again.
bool finite(const Event& event) {
  const auto is_finite = [](float v) { return std::isfinite(v); };
  return std::all_of(event.position, event.position + 3, is_finite) &&
         std::all_of(event.velocity, event.velocity + 3, is_finite);
}

}  // namespace

std::vector<Event> events_of(const Spawn& spawn, double time, const Store& parents,
                             const std::vector<std::uint32_t>& indices) {
  const simd::FloatMode mode;
  Store chosen(parents.schema());
  chosen.append(parents, indices);
  std::vector<Event> events;
  for (const std::uint32_t i : select(spawn.where, spawn.shapes, time, chosen)) {
    Event event{chosen.ids()[i], {}, {}};
    for (int c = 0; c < 3; ++c) {
      const float* v = chosen.plane(particles::velocity, c);
      event.position[c] = chosen.plane(particles::position, c)[i];
      event.velocity[c] = v != nullptr ? v[i] : chosen.uniform_value(particles::velocity)[static_cast<std::size_t>(c)];
    }
    if (finite(event)) events.push_back(event);
  }
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.id < b.id; });
  return events;
}

}  // namespace motes::program
