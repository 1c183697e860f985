// Where to cut: from the coordinates of one calculator's particles, or from all calculators' histograms.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace motes::balance {

/// Beyond all coordinates.
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A new cut inside the donor's domain, and how many of its particles are beyond it: never more than were asked for,
/// and fewer where particles at the same place cannot be told apart (half-open domains: x < cut is left, x >= cut is
/// right).
struct Gift {
  float cut = 0;
  std::uint64_t count = 0;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Gift& gift) {
  visit(gift.cut, gift.count);
}

/// Up to `wanted` particles of the donor with the highest (lowest) coordinates (paper 3.2.5). Coordinates are first
/// counted into bins, and only one bin is sorted. Particles whose coordinate is NaN or outside low <= x < high, the
/// donor's domain, stay. Nothing to give: the cut stays at the domain's end.
Gift give_right(std::span<const float> coordinates, std::uint64_t wanted, float low, float high);
Gift give_left(std::span<const float> coordinates, std::uint64_t wanted, float low, float high);

/// How one calculator's particles are distributed along the axis: counts between ascending edges, about equally many in
/// each bin as far as ties allow. There are counts.size() + 1 edges, and the last bin is closed; both are empty where
/// there are no particles.
struct Histogram {
  std::vector<float> edges;
  std::vector<std::uint64_t> counts;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Histogram& histogram) {
  visit(histogram.edges, histogram.counts);
}

/// At most `bins` of them, 1..4096. A sample of the coordinates chooses the edges; all coordinates are counted. A place
/// that many particles share gets a bin of its own. Coordinates that are not finite are left out.
Histogram histogram(std::span<const float> coordinates, int bins);

/// `quantiles` + 1 ascending coordinates that divide the particles evenly: how the log describes a domain. Exact to
/// less than a thousandth of the particles' extent, and as steady from frame to frame as the particles. Empty where
/// there are no particles.
std::vector<float> quantiles(std::span<const float> coordinates, int quantiles);

/// All cuts at once from global prefix sums: calculator c gets shares[c] of the sum of counts * costs (costs empty: 1
/// each). One histogram and one cost per calculator; histograms may overlap. Particles inside a bin count as evenly
/// spread. Cuts ascend; where a gap between particles or an empty domain leaves a choice, a cut stays as close to
/// `before` as possible. Nothing to divide: returns `before`.
std::vector<float> prefix_cuts(std::span<const Histogram> histograms, std::span<const double> costs,
                               std::span<const double> shares, std::span<const float> before);

}  // namespace motes::balance
