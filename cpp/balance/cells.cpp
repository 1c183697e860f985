#include "balance/cells.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "balance/cuts.h"
#include "balance/sample.h"
#include "base/invalid_argument.h"
#include "domains/divide.h"

namespace motes::balance {
namespace {

using domains::Axes;
using domains::Box;
using domains::Cut;
using domains::Places;

constexpr std::size_t kSamples = 16;  // per cell

// Returns a tree of `count` boxes with about equally many sampled particles in each.
domains::Domains grid_of(Axes axes, const Places& places, int count) {
  std::array<std::vector<float>, 3> sample;  // of the same particles on each axis
  Places of_sample;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!axes.has(static_cast<int>(axis))) continue;
    sample[axis] = sampled({places.position[axis], places.count}, kSamples * static_cast<std::size_t>(count));
    of_sample.position[axis] = sample[axis].data();
    of_sample.count = sample[axis].size();
  }
  return domains::quantiles(axes, of_sample, count, domains::Across::in_turn);
}

void add(Cell& cell, const std::array<float, 3>& at, Axes axes) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!axes.has(static_cast<int>(axis))) continue;
    cell.low[axis] = cell.count == 0 ? at[axis] : std::min(cell.low[axis], at[axis]);
    cell.high[axis] = cell.count == 0 ? at[axis] : std::max(cell.high[axis], at[axis]);
  }
  ++cell.count;
}

// Cost spread evenly over low <= x < high.
struct CostBox {
  std::array<float, 3> low, high;
  double cost;

  // Returns how much of the cost lies below `at`.
  double below(std::size_t axis, float at) const {
    if (at <= low[axis]) return 0;
    if (at >= high[axis]) return cost;
    const auto from = static_cast<double>(low[axis]);
    return cost * ((static_cast<double>(at) - from) / (static_cast<double>(high[axis]) - from));
  }
};

std::vector<CostBox> pieces_of(std::span<const std::vector<Cell>> cells, std::span<const double> costs) {
  std::vector<CostBox> pieces;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    for (const Cell& cell : cells[c]) {
      CostBox piece{cell.low, cell.high, static_cast<double>(cell.count) * (costs.empty() ? 1 : costs[c])};
      for (float& high : piece.high) high = std::nextafter(high, kInfinity);
      if (piece.cost > 0) pieces.push_back(piece);
    }
  }
  return pieces;
}

// Map floats to consecutive integers in the same order, and back.
std::int64_t place_of(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  return bits >= 0 ? std::int64_t{bits} : std::int64_t{std::numeric_limits<std::int32_t>::min()} - bits;
}
float number_at(std::int64_t place) {
  const std::int64_t bits = place >= 0 ? place : std::int64_t{std::numeric_limits<std::int32_t>::min()} - place;
  return std::bit_cast<float>(static_cast<std::int32_t>(bits));
}

// Places the cuts of a tree, from the root down.
class Sharing {
 public:
  Sharing(std::span<const double> shares, const domains::Domains& before) : shares_(shares), tree_(before.tree()) {}

  void divide(int first, int last, const Box& box, const std::vector<CostBox>& pieces) {
    if (last - first < 2) return;
    const int middle = first + domains::left_part(last - first);
    Cut& cut = tree_[static_cast<std::size_t>(middle - 1)];
    const auto axis = static_cast<std::size_t>(cut.axis);
    const double left = share(first, middle);
    const double all = left + share(middle, last);
    if (all > 0) cut.at = place(pieces, axis, left / all, cut.at);
    cut.at = std::clamp(cut.at, box.low[axis], box.high[axis]);
    Box below = box;
    Box above = box;
    below.high[axis] = above.low[axis] = cut.at;
    std::vector<CostBox> parts[2];
    for (const CostBox& piece : pieces) split(piece, axis, cut.at, parts[0], parts[1]);
    divide(first, middle, below, parts[0]);
    divide(middle, last, above, parts[1]);
  }

  domains::Domains domains() const { return domains::Domains::of(tree_); }

 private:
  double share(int first, int last) const {
    return std::accumulate(shares_.begin() + first, shares_.begin() + last, 0.0);
  }

  static double below(const std::vector<CostBox>& pieces, std::size_t axis, float at) {
    double sum = 0;
    for (const CostBox& piece : pieces) sum += piece.below(axis, at);
    return sum;
  }

  // Returns the position with this fraction of the cost below it; of several, the one closest to `before`.
  static float place(const std::vector<CostBox>& pieces, std::size_t axis, double part, float before) {
    double total = 0;
    float least = kInfinity;
    float most = -kInfinity;
    for (const CostBox& piece : pieces) {
      total += piece.cost;
      least = std::min(least, piece.low[axis]);
      most = std::max(most, piece.high[axis]);
    }
    if (!(total > 0)) return before;
    const double near = 1e-12 * total;
    const double target = total * part;
    // Bisects for the first position from `least` to `most` with enough cost below it; `most` always has enough.
    const auto first = [&](const auto& enough) {
      std::int64_t low = place_of(least);
      std::int64_t high = place_of(most);
      while (low < high) {
        const std::int64_t middle = low + (high - low) / 2;
        if (enough(below(pieces, axis, number_at(middle)))) {
          high = middle;
        } else {
          low = middle + 1;
        }
      }
      return low;
    };
    const bool all = target + near >= total;
    const float low = target <= near ? -kInfinity : number_at(first([&](double sum) { return sum >= target - near; }));
    const float high = all ? kInfinity : number_at(first([&](double sum) { return sum > target + near; }) - 1);
    return low <= high ? std::clamp(before, low, high) : low;
  }

  static void split(const CostBox& piece, std::size_t axis, float at, std::vector<CostBox>& left,
                    std::vector<CostBox>& right) {
    const double below = piece.below(axis, at);
    if (below > 0) {
      left.push_back(piece);
      left.back().cost = below;
      left.back().high[axis] = std::min(at, piece.high[axis]);
    }
    if (below < piece.cost) {
      right.push_back(piece);
      right.back().cost = piece.cost - below;
      right.back().low[axis] = std::max(at, piece.low[axis]);
    }
  }

  std::span<const double> shares_;
  std::vector<Cut> tree_;
};

}  // namespace

std::vector<Cell> cells(Axes axes, const Places& places, int most) {
  most = std::clamp(most, 1, 4096);
  const domains::Domains grid = grid_of(axes, places, most);
  std::vector<Cell> cells(static_cast<std::size_t>(most));
  constexpr std::size_t kAtATime = 1024;
  std::array<std::uint32_t, kAtATime> owners;
  for (std::size_t first = 0; first < places.count; first += kAtATime) {
    Places some = places;
    some.count = std::min(kAtATime, places.count - first);
    for (const float*& plane : some.position) plane = plane == nullptr ? nullptr : plane + first;
    grid.owners_of(some, owners.data());
    for (std::size_t p = 0; p < some.count; ++p) {
      std::array<float, 3> at{};
      bool finite = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!axes.has(static_cast<int>(axis))) continue;
        at[axis] = some.position[axis][p];
        finite = finite && std::abs(at[axis]) < std::numeric_limits<float>::max();
      }
      if (finite) add(cells[owners[p]], at, axes);
    }
  }
  std::erase_if(cells, [](const Cell& cell) { return cell.count == 0; });
  return cells;
}

domains::Domains tree_cuts(std::span<const std::vector<Cell>> cells, std::span<const double> costs,
                           std::span<const double> shares, const domains::Domains& before) {
  const auto calculators = static_cast<std::size_t>(before.count());
  const bool fits =
      cells.size() == calculators && shares.size() == calculators && (costs.empty() || costs.size() == calculators);
  if (!fits) throw base::InvalidArgument("shares", "be one per domain", std::to_string(shares.size()));
  Sharing sharing(shares, before);
  sharing.divide(0, before.count(), {}, pieces_of(cells, costs));
  return sharing.domains();
}

}  // namespace motes::balance
