// The distribution of particles along the axis: counts in bins, quantiles.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "balance/cuts.h"
#include "balance/sample.h"

namespace motes::balance {
namespace {

// False also for the largest float, so that the next float above a coordinate, the end of a half-open bin, is finite.
bool finite(float x) { return std::abs(x) < std::numeric_limits<float>::max(); }

std::vector<float> sorted_sample(std::span<const float> coordinates, std::size_t count) {
  std::vector<float> sample = sampled(coordinates, count);
  std::erase_if(sample, [](float x) { return !finite(x); });
  std::sort(sample.begin(), sample.end());
  return sample;
}

// Returns ascending edges from `least` to `most`. A coordinate with more than one bin's part of the sample gets its own
// bin, as narrow as floats allow.
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

// Counts the finite coordinates by a branchless binary search of fixed length among at most 2^Steps - 1 inner edges.
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

constexpr std::size_t kSorted = 512;        // at most this many coordinates are sorted
constexpr std::size_t kCounted = 1u << 18;  // of more than these, only every second, third, ... is counted

// Counts in bins whose width is a power of two and whose edges are its multiples. While particles stay about where they
// are, the edges do not change between frames, so the counts change only with the particles.
class Grid {
 public:
  Grid(std::span<const float> coordinates, const std::vector<float>& sample)
      : coordinates_(coordinates), step_((coordinates.size() + kCounted - 1) / kCounted) {
    const double low = sample[sample.size() / 64];
    const double high = sample[sample.size() - 1 - sample.size() / 64];
    int exponent = -126;
    if (high > low) std::frexp((high - low) / kInner, &exponent);
    width_ = std::ldexp(1.0, exponent);
    inverse_ = 1 / width_;
    base_ = std::floor((low - (high - low) / 16) / width_) * width_;
    count();
  }

  // Returns parts + 1 coordinates: exact in bins with many particles, elsewhere as if each bin were filled evenly.
  std::vector<float> quantiles(std::size_t parts) const {
    std::vector<float> found;
    std::uint64_t before = 0;
    std::size_t bin = 0;
    for (std::size_t i = 0; i <= parts; ++i) {
      const std::uint64_t place = (total_ - 1) * i / parts;
      while (before + counts_[bin] <= place) before += counts_[bin++];
      found.push_back(i == 0 ? least_ : i == parts ? most_ : at(bin, place - before));
    }
    std::sort(found.begin(), found.end());
    return found;
  }

 private:
  static constexpr int kInner = 1024;  // bins between the ends of the sample; at least half of them are used
  static constexpr int kBins = 1280;  // with those beyond the ends
  static constexpr std::size_t kOther = kBins + 2;  // counts non-finite coordinates

  std::size_t bin_of(float x) const {
    const double v = (x - base_) * inverse_;
    const auto bin = static_cast<std::size_t>(static_cast<int>(v > 0 ? v < kBins ? v + 1 : kBins + 1 : 0));
    return finite(x) ? bin : kOther;
  }

  void count() {
    for (std::size_t i = 0; i < coordinates_.size(); i += step_) {
      const float x = coordinates_[i];
      ++counts_[bin_of(x)];
      least_ = finite(x) && x < least_ ? x : least_;
      most_ = finite(x) && x > most_ ? x : most_;
    }
    for (std::size_t bin = 0; bin < kOther; ++bin) total_ += counts_[bin];
  }

  float at(std::size_t bin, std::uint64_t place) const {
    const bool inner = bin > 0 && bin <= static_cast<std::size_t>(kBins);
    if (!inner || counts_[bin] > total_ / 64) return exactly(bin, place);
    const double part = (static_cast<double>(place) + 0.5) / static_cast<double>(counts_[bin]);
    return std::clamp(static_cast<float>(base_ + (static_cast<double>(bin - 1) + part) * width_), least_, most_);
  }

  float exactly(std::size_t bin, std::uint64_t place) const {
    std::vector<float> here;
    for (std::size_t i = 0; i < coordinates_.size(); i += step_) {
      if (bin_of(coordinates_[i]) == bin) here.push_back(coordinates_[i]);
    }
    const auto wanted = here.begin() + static_cast<std::ptrdiff_t>(place);
    std::nth_element(here.begin(), wanted, here.end());
    return *wanted;
  }

  std::span<const float> coordinates_;
  std::size_t step_;
  double width_ = 1, inverse_ = 1, base_ = 0;
  std::array<std::uint64_t, kOther + 1> counts_{};
  std::uint64_t total_ = 0;
  float least_ = kInfinity, most_ = -kInfinity;
};

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

std::vector<float> quantiles(std::span<const float> coordinates, int quantiles) {
  const auto parts = static_cast<std::size_t>(std::max(quantiles, 1));
  std::vector<float> sample = sorted_sample(coordinates, kSorted);
  if (sample.empty()) return sample;
  if (coordinates.size() > kSorted) return Grid(coordinates, sample).quantiles(parts);
  std::vector<float> result;
  for (std::size_t i = 0; i <= parts; ++i) result.push_back(sample[(sample.size() - 1) * i / parts]);
  return result;
}

}  // namespace motes::balance
