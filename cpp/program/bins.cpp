// Finds the bin of a dimension that a number belongs to.
#include <algorithm>
#include <cmath>
#include <limits>

#include "program/sums.h"

namespace motes::program {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Return the smallest float32 that is at least an edge, or above it.
float at_least(double edge) {
  const auto near = static_cast<float>(edge);
  return near < edge ? std::nextafter(near, kInfinity) : near;
}
float above(double edge) {
  const float least = at_least(edge);
  return least == edge ? std::nextafter(least, kInfinity) : least;
}

bool evenly_spaced(const std::vector<double>& edges) {
  const double width = (edges.back() - edges.front()) / static_cast<double>(edges.size() - 1);
  if (!std::isfinite(width)) return false;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!(std::abs(edges[i] - edges.front() - width * static_cast<double>(i)) <= width)) return false;
  }
  return true;
}

}  // namespace

Bins::Bins(const Dimension& dimension)
    : count_(static_cast<std::uint32_t>(dimension.edges.size() - 1)), regular_(evenly_spaced(dimension.edges)),
      holds_infinity_(dimension.closed && std::isinf(dimension.edges.back())), first_(dimension.edges.front()),
      per_width_(count_ / (dimension.edges.back() - dimension.edges.front())), last_(count_ - 1) {
  for (const double edge : dimension.edges) starts_.push_back(at_least(edge));
  if (dimension.closed) starts_.back() = above(dimension.edges.back());
}

std::uint32_t Bins::search(float value) const {
  const auto after = std::upper_bound(starts_.begin(), starts_.end(), value);
  return static_cast<std::uint32_t>(after - starts_.begin() - 1);
}

}  // namespace motes::program
