#include "recording/order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "recording/select.h"

namespace motes::recording {

void order(const actions::Action& sort, particles::Store& store) {
  struct Place {
    double distance;
    std::uint64_t id;
    std::uint32_t index;
  };
  const double* eye = sort.numbers.data();
  const double* look = eye + 3;
  const std::vector<std::uint32_t> chosen = select(sort.where, sort.shapes, store);
  std::vector<Place> places;
  places.reserve(chosen.size());
  for (const std::uint32_t i : chosen) {
    double distance = 0;
    for (int c = 0; c < 3; ++c) {
      const float* x = store.plane(particles::position, c);
      const double at = x != nullptr ? x[i] : store.uniform_value(particles::position)[static_cast<std::size_t>(c)];
      distance += (at - eye[c]) * look[c];
    }
    if (std::isnan(distance)) distance = -std::numeric_limits<double>::infinity();
    places.push_back({distance, store.ids()[i], i});
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return a.distance != b.distance ? a.distance > b.distance : a.id < b.id;
  });
  std::vector<std::uint32_t> from(store.size());
  std::iota(from.begin(), from.end(), 0u);
  for (std::size_t k = 0; k < chosen.size(); ++k) from[chosen[k]] = places[k].index;
  store.permute(from);
}

}  // namespace motes::recording
