// Greedy refinement: the slowest calculator repeatedly gives to its faster neighbour.
#pragma once

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "balance/policy.h"
#include "balance/shares.h"

namespace motes::balance {

/// In each step the calculator that would be slowest gives particles to its faster neighbour until both need the same
/// time, unless they differ by no more than `threshold` or than noise can explain. No calculator gives more than it
/// holds, so particles that it takes are passed on in the next frame.
class Greedy : public Policy {
 public:
  const char* kind() const override { return "Greedy"; }
  Options options() override {
    return {{"threshold", NumberOption{&threshold_, 1}},
            {"min_particles", CountOption{&min_particles_}},
            smoothing(),
            over()};
  }
  Plan plan(const LoadTable& table) const override;

 private:
  static constexpr std::size_t kSteps = 8;  // steps per calculator

  double threshold_ = 0.05;
  std::uint64_t min_particles_ = 64;
};

inline Plan Greedy::plan(const LoadTable& table) const {
  Plan plan;
  const std::vector<double> speeds = complete(table.loads);
  std::vector<Load> loads = table.loads;
  std::vector<double> seconds = predicted_seconds(loads);
  std::vector<std::uint64_t> held;  // particles not yet given away
  held.reserve(loads.size());
  for (const Load& load : loads) held.push_back(load.particles);
  std::priority_queue<std::pair<double, std::size_t>> slowest;  // also holds outdated seconds, which are skipped
  for (std::size_t c = 0; c < loads.size(); ++c) slowest.emplace(seconds[c], c);
  for (std::size_t step = 0; loads.size() > 1 && !slowest.empty() && step < kSteps * loads.size(); ++step) {
    const auto [then_s, slow] = slowest.top();
    slowest.pop();
    if (then_s != seconds[slow]) continue;
    std::size_t other = slow == 0 ? 1 : slow - 1;
    if (slow > 0 && slow + 1 < loads.size() && seconds[slow + 1] < seconds[slow - 1]) other = slow + 1;
    const double both = speeds[slow] + speeds[other];
    const double surplus = std::floor((seconds[slow] - seconds[other]) * (speeds[slow] * speeds[other] / both));
    if (!apart(loads[slow], seconds[slow], loads[other], seconds[other], threshold_) || !(surplus > 0)) continue;
    const std::uint64_t count = std::min(held[slow], static_cast<std::uint64_t>(surplus));
    if (count < std::max<std::uint64_t>(min_particles_, 1)) continue;
    plan.orders.push_back({static_cast<std::int32_t>(slow), static_cast<std::int32_t>(other), count});
    held[slow] -= count;
    loads[slow].particles -= count;
    loads[other].particles += count;
    for (const std::size_t c : {slow, other}) seconds[c] = static_cast<double>(loads[c].particles) / speeds[c];
    const std::size_t left = std::min(slow, other);
    const std::size_t last = std::min(left + 3, loads.size());
    for (std::size_t c = left > 0 ? left - 1 : 0; c < last; ++c) slowest.emplace(seconds[c], c);  // may give now
  }
  for (std::size_t i = 0; i + 1 < loads.size(); ++i) plan.evaluated.push_back(static_cast<std::int32_t>(i));
  return plan;
}

}  // namespace motes::balance
