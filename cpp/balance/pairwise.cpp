#include "balance/pairwise.h"

#include <algorithm>
#include <cmath>

#include "balance/shares.h"
#include "base/invalid_argument.h"

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
  return "Pairwise(threshold=" + shown(threshold_) + (powers_.empty() ? "" : ", powers=" + shown(powers_)) +
         ", min_particles=" + std::to_string(min_particles_) + shown_options() + ")";
}

void Pairwise::check(std::size_t calculators) const {
  if (powers_.empty()) return;
  check_powers(*this, powers_, calculators);
  const bool positive = std::all_of(powers_.begin(), powers_.end(), [](double power) { return power > 0; });
  if (!positive) throw base::InvalidArgument("powers", "be above 0", "", name());
}

// Given powers say nothing about noise: then the threshold alone decides.
bool Pairwise::apart(const Load& l, const Load& r, double left_speed, double right_speed) const {
  if (!powers_.empty()) return balance::apart({}, l.seconds, {}, r.seconds, threshold_);
  const double left_s = static_cast<double>(l.particles) / left_speed;
  const double right_s = static_cast<double>(r.particles) / right_speed;
  return balance::apart(l, left_s, r, right_s, threshold_);
}

Plan Pairwise::plan(const Table& table) const {
  check(table.loads.size());
  const std::vector<double> speeds = powers_.empty() ? complete(table.loads) : powers_;
  const auto calculators = static_cast<std::int32_t>(table.loads.size());
  Plan plan;
  // Two calculators form only one pair: there is no other to start with.
  std::int32_t left = calculators > 2 ? static_cast<std::int32_t>(table.evaluation % 2) : 0;
  while (left + 1 < calculators) {
    const auto i = static_cast<std::size_t>(left);
    const Load& l = table.loads[i];
    const Load& r = table.loads[i + 1];
    plan.evaluated.push_back(left);
    const Order order = equal_times(left, l, r, speeds[i], speeds[i + 1]);
    const bool balances =
        apart(l, r, speeds[i], speeds[i + 1]) && order.count >= std::max<std::uint64_t>(min_particles_, 1);
    if (balances) plan.orders.push_back(order);
    left += balances ? 2 : 1;
  }
  return plan;
}

}  // namespace motes::balance
