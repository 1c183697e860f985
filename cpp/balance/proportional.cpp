#include "balance/proportional.h"

#include <cmath>

#include "balance/shares.h"

namespace motes::balance {

std::string Proportional::name() const {
  return "Proportional(powers=" + shown(powers_) + ", threshold=" + shown(threshold_) +
         ", min_particles=" + std::to_string(min_particles_) + (over_all ? ", over=\"all\"" : "") + ")";
}

void Proportional::check(std::size_t calculators) const { check_powers(*this, powers_, calculators); }

Plan Proportional::plan(const Table& table) const {
  check(table.loads.size());
  Plan plan;
  for (std::size_t i = 0; i + 1 < table.loads.size(); ++i) plan.evaluated.push_back(static_cast<std::int32_t>(i));
  const std::vector<double> wants = wanted(table.loads, powers_, {});
  bool apart = false;
  for (std::size_t c = 0; c < wants.size(); ++c) {
    const double off = std::abs(static_cast<double>(table.loads[c].particles) - wants[c]);
    apart = apart || (off > threshold_ * wants[c] && off >= static_cast<double>(min_particles_));
  }
  if (apart) plan.shares = powers_;
  return plan;
}

}  // namespace motes::balance
