#include "balance/pairwise.h"

#include <algorithm>
#include <cmath>

namespace motes::balance {
namespace {

// The order after which both hold particles in proportion to their processing power.
Order equal_times(std::int32_t left, const Load& l, const Load& r, double left_speed, double right_speed) {
  const double both = static_cast<double>(l.particles) + static_cast<double>(r.particles);
  const double wanted = std::round(both * (left_speed / (left_speed + right_speed)));
  const double surplus = static_cast<double>(l.particles) - wanted;
  if (surplus > 0) return {left, left + 1, std::min(l.particles, static_cast<std::uint64_t>(surplus))};
  return {left + 1, left, std::min(r.particles, static_cast<std::uint64_t>(-surplus))};
}

}  // namespace

std::string Pairwise::name() const {
  return "Pairwise(threshold=" + shown(threshold_) + ", min_particles=" + std::to_string(min_particles_) +
         shown_options() + ")";
}

Plan Pairwise::plan(const Table& table) const {
  const std::vector<double> speeds = complete(table.loads);
  const auto calculators = static_cast<std::int32_t>(table.loads.size());
  Plan plan;
  // Two calculators form only one pair: there is no other to start with.
  std::int32_t left = calculators > 2 ? static_cast<std::int32_t>(table.evaluation % 2) : 0;
  while (left + 1 < calculators) {
    const auto i = static_cast<std::size_t>(left);
    const Load& l = table.loads[i];
    const Load& r = table.loads[i + 1];
    const double left_s = static_cast<double>(l.particles) / speeds[i];
    const double right_s = static_cast<double>(r.particles) / speeds[i + 1];
    plan.evaluated.push_back(left);
    const Order order = equal_times(left, l, r, speeds[i], speeds[i + 1]);
    const bool balances =
        apart(l, left_s, r, right_s, threshold_) && order.count >= std::max<std::uint64_t>(min_particles_, 1);
    if (balances) plan.orders.push_back(order);
    left += balances ? 2 : 1;
  }
  return plan;
}

}  // namespace motes::balance
