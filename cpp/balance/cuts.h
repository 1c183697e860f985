// Computes where to cut, from the coordinates of one calculator's particles or from all calculators' histograms.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace motes::balance {

/// Beyond all coordinates.
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A new cut inside the donor's domain, and how many of its particles lie beyond it: at most the requested number, and
/// fewer if several particles share the coordinate of the cut (domains are half-open: x < cut is left, x >= cut is
/// right).
struct Gift {
  float cut = 0;
  std::uint64_t count = 0;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Gift& gift) {
  visit(gift.cut, gift.count);
}

/// Cut off up to `wanted` of the donor's particles with the highest (lowest) coordinates (paper 3.2.5). Coordinates are
/// first counted into bins, and only one bin is sorted. Particles whose coordinate is NaN or outside the donor's
/// domain, low <= x < high, stay. If there is nothing to give, the cut stays at the domain's end.
Gift give_right(std::span<const float> coordinates, std::uint64_t wanted, float low, float high);
Gift give_left(std::span<const float> coordinates, std::uint64_t wanted, float low, float high);

/// The distribution of one calculator's particles along the axis: counts between ascending edges, about equal as far as
/// ties allow. There are counts.size() + 1 edges, and the last bin is closed. Both are empty if there are no particles.
struct Histogram {
  std::vector<float> edges;
  std::vector<std::uint64_t> counts;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Histogram& histogram) {
  visit(histogram.edges, histogram.counts);
}

/// Returns a histogram of at most `bins` bins, 1..4096. A sample chooses the edges, but all coordinates are counted. A
/// coordinate that many particles share gets its own bin. Non-finite coordinates are ignored.
Histogram histogram(std::span<const float> coordinates, int bins);

/// Returns `quantiles` + 1 ascending coordinates that divide the particles evenly, as the log describes domains. They
/// are exact to less than a thousandth of the particles' extent, and as steady from frame to frame as the particles.
/// Empty if there are no particles.
std::vector<float> quantiles(std::span<const float> coordinates, int quantiles);

/// Computes all cuts at once from global prefix sums: calculator c gets shares[c] of the sum of counts * costs (costs
/// empty: 1 each). There is one histogram and one cost per calculator. Histograms may overlap; particles count as
/// evenly spread over their bin. Cuts ascend. Where a gap between particles or an empty domain leaves a choice, a cut
/// stays as close to `before` as possible. Returns `before` if there is nothing to divide.
std::vector<float> prefix_cuts(std::span<const Histogram> histograms, std::span<const double> costs,
                               std::span<const double> shares, std::span<const float> before);

}  // namespace motes::balance
