#include "domains/domains.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace motes::domains {

Domains::Domains(std::vector<float> cuts) : cuts_(std::move(cuts)) {
  for (std::size_t i = 0; i < cuts_.size(); ++i) {
    const bool ascends = i == 0 || cuts_[i - 1] <= cuts_[i];
    if (std::isnan(cuts_[i]) || !ascends) throw std::invalid_argument("cuts must be ascending numbers");
  }
}

int Domains::owner_of(float x) const {
  // Not a number compares false with every cut: the search ends at the last domain.
  return static_cast<int>(std::upper_bound(cuts_.begin(), cuts_.end(), x) - cuts_.begin());
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
