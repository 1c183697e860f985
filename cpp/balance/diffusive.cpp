#include "balance/diffusive.h"

#include <algorithm>
#include <cmath>

namespace motes::balance {

std::string Diffusive::name() const {
  return "Diffusive(threshold=" + shown(threshold_) + ", rate=" + shown(rate_) +
         ", min_particles=" + std::to_string(min_particles_) + (manager_ ? "" : ", manager=False") + shown_options() +
         ")";
}

Order Diffusive::between(std::int32_t left, const Load& left_load, const Load& right_load) const {
  const std::vector<double> speeds = complete({left_load, right_load});
  const double left_s = static_cast<double>(left_load.particles) / speeds[0];
  const double right_s = static_cast<double>(right_load.particles) / speeds[1];
  const double difference = std::abs(left_s - right_s);
  const bool to_right = left_s > right_s;
  Order order{to_right ? left : left + 1, to_right ? left + 1 : left, 0};
  if (!apart(left_load, left_s, right_load, right_s, threshold_)) return order;
  const double flow = rate_ * difference * std::min(speeds[0], speeds[1]) / 2;
  const std::uint64_t half = (to_right ? left_load : right_load).particles / 2;
  const std::uint64_t count = std::min(half, static_cast<std::uint64_t>(std::round(flow)));
  if (count >= std::max<std::uint64_t>(min_particles_, 1)) order.count = count;
  return order;
}

Plan Diffusive::plan(const Table& table) const {
  Plan plan;
  for (std::size_t i = 0; i + 1 < table.loads.size(); ++i) {
    const auto left = static_cast<std::int32_t>(i);
    plan.evaluated.push_back(left);
    const Order order = between(left, table.loads[i], table.loads[i + 1]);
    if (order.count > 0) plan.orders.push_back(order);
  }
  return plan;
}

}  // namespace motes::balance
