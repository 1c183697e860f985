// Moves all cuts at once, from global prefix sums of cost along the axis: particles may move across several domains.
#pragma once

#include "balance/policy.h"
#include "balance/shares.h"

namespace motes::balance {

/// Sets new cuts if a calculator's time is above the mean by more than `threshold` and by more than noise can explain,
/// and some calculator is off by at least `min_particles`.
class PrefixCuts : public Policy {
 public:
  const char* kind() const override { return "PrefixCuts"; }
  Options options() override {
    return {{"threshold", NumberOption{&threshold_}},
            {"powers", PowersOption{&powers_}},
            {"min_particles", CountOption{&min_particles_}},
            smoothing(),
            over()};
  }
  Plan plan(const LoadTable& table) const override;
  void check(std::size_t calculators) const override {
    if (!powers_.empty()) check_powers(*this, powers_, calculators);
  }

 private:
  std::vector<double> costs(const std::vector<Load>& loads) const;

  double threshold_ = 0.05;
  std::uint64_t min_particles_ = 64;
  // Empty: the cost of a particle depends on the machine, and each calculator gets particles by its measured speed.
  // Given: the machines are known, the cost of a particle depends on its position, and each calculator gets its power's
  // share of the total cost.
  std::vector<double> powers_;
};

// Returns the cost of a particle in each domain on a machine of power 1; the mean of the known costs where no speed is
// known.
inline std::vector<double> PrefixCuts::costs(const std::vector<Load>& loads) const {
  std::vector<double> costs(loads.size(), 0.0);
  double sum = 0;
  int known = 0;
  for (std::size_t c = 0; c < loads.size(); ++c) {
    if (!(loads[c].speed > 0)) continue;
    sum += costs[c] = powers_[c] / loads[c].speed;
    ++known;
  }
  for (double& cost : costs) {
    if (cost == 0) cost = known > 0 ? sum / known : 1;
  }
  return costs;
}

inline Plan PrefixCuts::plan(const LoadTable& table) const {
  check(table.loads.size());
  Plan plan;
  plan.shares = powers_.empty() ? complete(table.loads) : powers_;
  if (!powers_.empty()) plan.costs = costs(table.loads);
  for (std::size_t i = 0; i + 1 < table.loads.size(); ++i) plan.evaluated.push_back(static_cast<std::int32_t>(i));
  if (above_mean(table.loads, threshold_) &&
      most_off(table.loads, wanted(table.loads, plan.shares, plan.costs)) >= static_cast<double>(min_particles_))
    return plan;
  plan.shares.clear();
  plan.costs.clear();
  return plan;
}

}  // namespace motes::balance
