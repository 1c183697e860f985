#include "balance/prefix_cuts.h"

#include "balance/shares.h"

namespace motes::balance {

std::string PrefixCuts::name() const {
  return "PrefixCuts(threshold=" + shown(threshold_) + (powers_.empty() ? "" : ", powers=" + shown(powers_)) +
         ", min_particles=" + std::to_string(min_particles_) + shown_options() + ")";
}

void PrefixCuts::check(std::size_t calculators) const {
  if (!powers_.empty()) check_powers(*this, powers_, calculators);
}

// The cost of a particle in each domain, on a machine of power 1; where no speed is known, the mean of the known ones.
std::vector<double> PrefixCuts::costs(const std::vector<Load>& loads) const {
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

Plan PrefixCuts::plan(const Table& table) const {
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
