#include "balance/sample.h"

#include <algorithm>
#include <cmath>

namespace motes::balance {

std::vector<float> sampled(std::span<const float> coordinates, std::size_t count) {
  if (coordinates.size() <= count) return {coordinates.begin(), coordinates.end()};
  std::vector<float> sample;
  sample.reserve(count);
  const double stretch = static_cast<double>(coordinates.size()) / static_cast<double>(count);
  constexpr double kGolden = 0.6180339887498949;  // multiples of it, modulo 1, fill the unit interval evenly
  for (std::size_t i = 0; i < count; ++i) {
    const double turns = static_cast<double>(i) * kGolden;
    const double place = (static_cast<double>(i) + turns - std::floor(turns)) * stretch;
    sample.push_back(coordinates[std::min(static_cast<std::size_t>(place), coordinates.size() - 1)]);
  }
  return sample;
}

}  // namespace motes::balance
