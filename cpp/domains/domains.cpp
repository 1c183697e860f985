#include "domains/domains.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace motes::domains {

Domains::Domains(std::vector<float> cuts) : cuts_(std::move(cuts)) {
  for (std::size_t i = 0; i < cuts_.size(); ++i) {
    const bool ascends = i == 0 || cuts_[i - 1] <= cuts_[i];
    if (std::isnan(cuts_[i]) || !ascends) throw std::invalid_argument("cuts must be in ascending order, without NaN");
  }
}

// The number of cuts at or below x. Each step halves the remaining range without a branch, for several particles side
// by side: with thousands of cuts and unsorted particles, a processor would mispredict every second branch and wait for
// each load.
void Domains::owners_of(std::span<const float> x, std::uint32_t* owners) const {
  constexpr std::size_t kAbreast = 16;
  const float* const cuts = cuts_.data();
  for (std::size_t first = 0; first < x.size(); first += kAbreast) {
    const std::size_t count = std::min(kAbreast, x.size() - first);
    std::uint32_t* const below = owners + first;
    std::fill_n(below, count, 0u);
    for (auto left = static_cast<std::uint32_t>(cuts_.size()); left > 0;) {
      const std::uint32_t half = (left + 1) / 2;
      // NaN compares false with every cut: its search ends at the last domain.
      for (std::size_t i = 0; i < count; ++i) {
        below[i] += half * static_cast<std::uint32_t>(!(x[first + i] < cuts[below[i] + half - 1]));
      }
      left -= half;
    }
  }
}

float Domains::low(int domain) const {
  return domain == 0 ? -std::numeric_limits<float>::infinity() : cuts_[static_cast<std::size_t>(domain - 1)];
}

float Domains::high(int domain) const {
  return domain == count() - 1 ? std::numeric_limits<float>::infinity() : cuts_[static_cast<std::size_t>(domain)];
}

Domains equal_slices(double low, double high, int count) {
  std::vector<float> cuts;
  for (int i = 1; i < count; ++i) cuts.push_back(static_cast<float>(low + (high - low) * i / count));
  return Domains(std::move(cuts));
}

Domains quantiles(std::span<const float> coordinates, int count) {
  std::vector<float> sorted(coordinates.begin(), coordinates.end());
  std::erase_if(sorted, [](float x) { return std::isnan(x); });
  if (sorted.empty()) return equal_slices(-kInfinite, kInfinite, count);
  std::vector<float> cuts;
  auto from = sorted.begin();
  for (int i = 1; i < count; ++i) {
    const auto nth = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * static_cast<std::size_t>(i) /
                                                                  static_cast<std::size_t>(count));
    std::nth_element(from, nth, sorted.end());
    cuts.push_back(*nth);
    from = nth;
  }
  return Domains(std::move(cuts));
}

}  // namespace motes::domains
