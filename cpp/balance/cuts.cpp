#include "balance/cuts.h"

#include <algorithm>
#include <cmath>

#include "balance/sample.h"

namespace motes::balance {
namespace {

// The particles that may be given away: those inside the domain. NaN is outside.
struct Domain {
  std::span<const float> coordinates;
  float low, high;

  bool holds(float x) const { return x >= low && x < high; }
  std::uint64_t count() const { return between(low, high); }
  // Counts the particles in [from, to), a part of the domain.
  std::uint64_t between(float from, float to) const {
    std::uint64_t n = 0;
    for (const float x : coordinates) n += static_cast<std::uint64_t>((x >= from) & (x < to));
    return n;
  }
  float largest() const {
    float most = -kInfinity;
    for (const float x : coordinates) most = holds(x) && x > most ? x : most;
    return most;
  }
  // Returns the smallest coordinate of the domain above x, or `high` if there is none.
  float next(float x) const {
    float least = high;
    for (const float y : coordinates) least = y > x && y < least ? y : least;
    return least;
  }
};

// The coordinate at a rank in ascending order, and how many coordinates are strictly below it.
struct Ranked {
  float value = 0;
  std::uint64_t below = 0;
};

// Selects by rank. A sample gives the edges of three bins, of which the middle one should hold the rank; counting finds
// the right one, and only that bin is partially sorted (R. W. Floyd and R. L. Rivest, "Expected time bounds for
// selection", Communications of the ACM 18 (1975)).
Ranked ranked(const Domain& domain, std::uint64_t count, std::uint64_t rank) {
  std::vector<float> sample = sampled(domain.coordinates, 2048);
  std::erase_if(sample, [&](float x) { return !domain.holds(x); });
  std::sort(sample.begin(), sample.end());
  const double place = static_cast<double>(rank) / static_cast<double>(count) * static_cast<double>(sample.size());
  const double margin = 1.5 * std::sqrt(static_cast<double>(sample.size()));
  const auto edge = [&](double at, float beyond) {
    if (at < 0 || at >= static_cast<double>(sample.size())) return beyond;
    return sample[static_cast<std::size_t>(at)];
  };
  float from = domain.low;
  float to = edge(place - margin, domain.low);
  std::uint64_t below = 0;
  std::uint64_t inside = domain.between(from, to);
  for (const float next : {edge(place + margin, domain.high), domain.high}) {
    if (rank < below + inside) break;
    below += inside;
    from = to;
    to = next;
    inside = domain.between(from, to);
  }
  std::vector<float> bin(inside + 1);  // one more: every coordinate is written, but kept only if the count advances
  std::size_t kept = 0;
  for (const float x : domain.coordinates) {
    bin[kept] = x;
    kept += static_cast<std::size_t>((x >= from) & (x < to));
  }
  const auto nth = bin.begin() + static_cast<std::ptrdiff_t>(rank - below);
  std::nth_element(bin.begin(), nth, bin.end() - 1);
  const float value = *nth;
  const auto less = std::count_if(bin.begin(), nth, [&](float x) { return x < value; });
  return {value, below + static_cast<std::uint64_t>(less)};
}

}  // namespace

Gift give_left(std::span<const float> coordinates, std::uint64_t wanted, float low, float high) {
  const Domain domain{coordinates, low, high};
  const std::uint64_t count = domain.count();
  if (wanted == 0 || count == 0) return {low, 0};
  if (wanted >= count) return {std::nextafter(domain.largest(), kInfinity), count};
  const Ranked first_kept = ranked(domain, count, wanted);
  return {first_kept.below == 0 ? low : first_kept.value, first_kept.below};
}

Gift give_right(std::span<const float> coordinates, std::uint64_t wanted, float low, float high) {
  const Domain domain{coordinates, low, high};
  const std::uint64_t count = domain.count();
  if (wanted == 0 || count == 0) return {high, 0};
  const std::uint64_t kept = count - std::min(wanted, count);
  const Ranked first_given = ranked(domain, count, kept);
  if (first_given.below == kept) return {first_given.value, count - kept};
  // Some particles at this coordinate must stay, so all of them do.
  const float cut = domain.next(first_given.value);
  return {cut, domain.between(cut, high)};
}

}  // namespace motes::balance
