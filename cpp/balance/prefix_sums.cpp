// All cuts at once from global prefix sums of cost along the axis.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "balance/cuts.h"
#include "base/invalid_argument.h"

namespace motes::balance {
namespace {

// Cost spread evenly over low <= x < high.
struct Interval {
  float low, high;
  double cost;
};

std::vector<Interval> intervals_of(std::span<const Histogram> histograms, std::span<const double> costs) {
  std::vector<Interval> intervals;
  for (std::size_t c = 0; c < histograms.size(); ++c) {
    const Histogram& h = histograms[c];
    if (!h.counts.empty() && h.edges.size() != h.counts.size() + 1) {
      throw base::InvalidArgument("edges", "have one more number than counts", std::to_string(h.edges.size()));
    }
    for (std::size_t i = 0; i < h.counts.size(); ++i) {
      const double cost = static_cast<double>(h.counts[i]) * (costs.empty() ? 1 : costs[c]);
      if (!(cost > 0)) continue;
      // The last bin is closed; as a half-open interval it ends at the next float.
      const bool last = i + 1 == h.counts.size();
      intervals.push_back({h.edges[i], last ? std::nextafter(h.edges[i + 1], kInfinity) : h.edges[i + 1], cost});
    }
  }
  return intervals;
}

bool in_order(const std::vector<Interval>& intervals) {
  for (std::size_t i = 1; i < intervals.size(); ++i) {
    if (intervals[i].low < intervals[i - 1].high) return false;
  }
  return true;
}

// A sum of numbers that are added and removed. It is exactly 0 when all are gone, as nothing is ever subtracted.
class ChangingSum {
 public:
  explicit ChangingSum(std::size_t count) : leaves_(std::bit_ceil(count)), tree_(2 * leaves_, 0.0) {}

  void set(std::size_t i, double value) {
    i += leaves_;
    tree_[i] = value;
    for (i /= 2; i > 0; i /= 2) tree_[i] = tree_[2 * i] + tree_[2 * i + 1];
  }
  double sum() const { return tree_[1]; }

 private:
  std::size_t leaves_;
  std::vector<double> tree_;
};

// Returns the same costs as disjoint intervals in ascending order.
std::vector<Interval> flattened(const std::vector<Interval>& intervals) {
  struct Event {
    float x;
    bool begins;
    std::size_t interval;
  };
  std::vector<Event> events;
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    events.push_back({intervals[i].low, true, i});
    events.push_back({intervals[i].high, false, i});
  }
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.x < b.x; });
  const auto width = [](const Interval& p) { return static_cast<double>(p.high) - static_cast<double>(p.low); };
  ChangingSum density(std::max<std::size_t>(intervals.size(), 2));
  std::vector<Interval> flat;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Interval& p = intervals[events[i].interval];
    density.set(events[i].interval, events[i].begins ? p.cost / width(p) : 0.0);
    if (i + 1 == events.size() || events[i + 1].x == events[i].x) continue;
    Interval part{events[i].x, events[i + 1].x, 0};
    part.cost = density.sum() * width(part);
    if (part.cost > 0) flat.push_back(part);
  }
  return flat;
}

// Walks along the axis to positions with given costs to their left.
class Walk {
 public:
  Walk(const std::vector<Interval>& intervals, double total) : intervals_(intervals), near_(1e-12 * total) {}

  /// Returns the position with a cost of `target` to its left; in a gap, the one closest to `before`. Targets must
  /// ascend from call to call.
  float cut(double target, float before) {
    while (at_ < intervals_.size() && passed_ + intervals_[at_].cost <= target + near_)
      passed_ += intervals_[at_++].cost;
    const float gap_low = at_ == 0 ? -kInfinity : intervals_[at_ - 1].high;
    const float gap_high = at_ == intervals_.size() ? kInfinity : intervals_[at_].low;
    if (at_ == intervals_.size() || target <= passed_ + near_) return std::clamp(before, gap_low, gap_high);
    const Interval& p = intervals_[at_];
    const double width = static_cast<double>(p.high) - static_cast<double>(p.low);
    const double x = static_cast<double>(p.low) + width * ((target - passed_) / p.cost);
    return std::clamp(static_cast<float>(x), p.low, p.high);
  }

 private:
  const std::vector<Interval>& intervals_;
  double near_;
  double passed_ = 0;
  std::size_t at_ = 0;
};

}  // namespace

std::vector<float> prefix_cuts(std::span<const Histogram> histograms, std::span<const double> costs,
                               std::span<const double> shares, std::span<const float> before) {
  const std::size_t calculators = shares.size();
  const bool fits = histograms.size() == calculators && before.size() + 1 == calculators &&
                    (costs.empty() || costs.size() == calculators);
  if (!fits) throw base::InvalidArgument("shares", "be one per histogram", std::to_string(calculators));
  std::vector<float> cuts(before.begin(), before.end());
  std::vector<Interval> intervals = intervals_of(histograms, costs);
  if (!in_order(intervals)) intervals = flattened(intervals);
  const double total = std::accumulate(intervals.begin(), intervals.end(), 0.0,
                                       [](double sum, const Interval& p) { return sum + p.cost; });
  const double parts = std::accumulate(shares.begin(), shares.end(), 0.0);
  if (!(total > 0) || !(parts > 0)) return cuts;
  Walk walk(intervals, total);
  double part = 0;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    part += shares[i];
    cuts[i] = walk.cut(total * std::min(part / parts, 1.0), before[i]);
    if (i > 0) cuts[i] = std::max(cuts[i], cuts[i - 1]);
  }
  return cuts;
}

}  // namespace motes::balance
