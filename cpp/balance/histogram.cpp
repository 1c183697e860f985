// How particles are distributed along the axis: counts in bins, quantiles of a sample.
#include <algorithm>
#include <cmath>
#include <limits>

#include "balance/cuts.h"
#include "balance/sample.h"

namespace motes::balance {
namespace {

// The next number above it: the end of a half-open bin.
bool finite(float x) { return std::abs(x) < std::numeric_limits<float>::max(); }

std::vector<float> sorted_sample(std::span<const float> coordinates, std::size_t count) {
  std::vector<float> sample = sampled(coordinates, count);
  std::erase_if(sample, [](float x) { return !finite(x); });
  std::sort(sample.begin(), sample.end());
  return sample;
}

// Ascending edges between `least` and `most`. A place that takes more of the sample than one bin's part gets a bin of
// its own, as narrow as floats allow.
std::vector<float> edges_between(float least, float most, const std::vector<float>& sample, int bins) {
  std::vector<float> edges{least};
  const auto add = [&](float x) {
    if (x > edges.back() && x <= most) edges.push_back(x);
  };
  const auto count = static_cast<std::size_t>(bins);
  for (std::size_t i = 1; i < count && !sample.empty(); ++i) {
    const float x = sample[sample.size() * i / count];
    const bool again = x == edges.back();
    add(again ? std::nextafter(x, kInfinity) : x);
  }
  edges.push_back(most);
  return edges;
}

// Counts the finite coordinates, by a search of fixed length without branches among at most 2^Steps - 1 inner edges.
template <int Steps>
std::vector<std::uint64_t> counted(std::span<const float> coordinates, const std::vector<float>& edges) {
  std::vector<float> inner(1u << Steps, kInfinity);
  std::copy(edges.begin() + 1, edges.end() - 1, inner.begin());
  std::vector<std::uint64_t> counts(inner.size(), 0);
  const float* const edge = inner.data();
  for (const float x : coordinates) {
    std::uint32_t bin = 0;
#pragma GCC unroll 12
    for (int step = Steps - 1; step >= 0; --step) {
      bin += static_cast<std::uint32_t>(x >= edge[bin + (1u << step) - 1]) << step;
    }
    counts[bin] += static_cast<std::uint64_t>(finite(x));
  }
  counts.resize(edges.size() - 1);
  return counts;
}

}  // namespace

Histogram histogram(std::span<const float> coordinates, int bins) {
  float least = kInfinity;
  float most = -kInfinity;
  for (const float x : coordinates) {
    least = finite(x) && x < least ? x : least;
    most = finite(x) && x > most ? x : most;
  }
  if (least > most) return {};
  bins = std::clamp(bins, 1, 4096);
  const std::vector<float> sample = sorted_sample(coordinates, 16 * static_cast<std::size_t>(bins));
  Histogram histogram;
  histogram.edges = edges_between(least, most, sample, bins);
  const std::size_t made = histogram.edges.size() - 1;
  const auto count = made <= 64 ? &counted<6> : made <= 256 ? &counted<8> : &counted<12>;
  histogram.counts = count(coordinates, histogram.edges);
  return histogram;
}

std::vector<float> quantiles(std::span<const float> coordinates, int quantiles, std::size_t sample) {
  const std::vector<float> sorted = sorted_sample(coordinates, sample);
  std::vector<float> result;
  if (sorted.empty()) return result;
  const auto parts = static_cast<std::size_t>(std::max(quantiles, 1));
  for (std::size_t i = 0; i <= parts; ++i) result.push_back(sorted[(sorted.size() - 1) * i / parts]);
  return result;
}

}  // namespace motes::balance
