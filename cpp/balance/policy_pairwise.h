// The paper's balancing (3.2.5): the manager evaluates pairs of neighbours.
#pragma once

#include <algorithm>
#include <cmath>

#include "balance/policy.h"
#include "balance/shares.h"

namespace motes::balance {

/// Evaluates pairs (x, x + 1) from left to right, starting alternately with the first and the second pair. After a pair
/// (x, x + 1) that balances, the next one is (x + 2, x + 3), so each calculator only gives or only takes, and with one
/// neighbour.
class Pairwise : public Policy {
 public:
  const char* kind() const override { return "Pairwise"; }
  Options options() override {
    return {{"threshold", NumberOption{&threshold_, 1}},
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
  static Order equal_times(std::int32_t left, const Load& l, const Load& r, double left_speed, double right_speed);
  bool apart(const Load& l, const Load& r, double left_speed, double right_speed) const;

  // A pair balances if its times differ by more than this fraction of the longer one and by more than noise can
  // explain.
  double threshold_ = 0.10;
  std::uint64_t min_particles_ = 64;  // fewer particles do not move: their message costs more than it saves
  // If given, as in the paper: times are those measured in the last frame, and a pair divides its particles in
  // proportion to its powers. Empty: both follow from measured speeds.
  std::vector<double> powers_;
};

// Returns the order after which both hold particles in proportion to their processing power.
inline Order Pairwise::equal_times(std::int32_t left, const Load& l, const Load& r, double left_speed,
                                   double right_speed) {
  const double both = static_cast<double>(l.particles) + static_cast<double>(r.particles);
  const double wanted = std::round(both * (left_speed / (left_speed + right_speed)));
  const double surplus = static_cast<double>(l.particles) - wanted;
  if (surplus > 0) return {left, left + 1, std::min(l.particles, static_cast<std::uint64_t>(surplus))};
  return {left + 1, left, std::min(r.particles, static_cast<std::uint64_t>(-surplus))};
}

// With given powers the noise is unknown, so only the threshold decides.
inline bool Pairwise::apart(const Load& l, const Load& r, double left_speed, double right_speed) const {
  if (!powers_.empty()) return balance::apart({}, l.seconds, {}, r.seconds, threshold_);
  const double left_s = static_cast<double>(l.particles) / left_speed;
  const double right_s = static_cast<double>(r.particles) / right_speed;
  return balance::apart(l, left_s, r, right_s, threshold_);
}

inline Plan Pairwise::plan(const LoadTable& table) const {
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
