// Load that diffuses like heat: neighbours decide among themselves. This is the paper's future work (section 6); for
// first-order diffusion see G. Cybenko, "Dynamic load balancing for distributed memory multiprocessors", Journal of
// Parallel and Distributed Computing 7 (1989).
#pragma once

#include <algorithm>
#include <cmath>

#include "balance/policy.h"

namespace motes::balance {

/// Moves over each cut `rate` times half the difference in time, at the speed of the slower neighbour, which is stable
/// for any speeds up to rate 1. Never moves more than half of the donor's particles over one cut.
class Diffusive : public Policy {
 public:
  const char* kind() const override { return "Diffusive"; }
  Options options() override {
    return {{"threshold", NumberOption{&threshold_, 1}},
            {"rate", NumberOption{&rate_, 1}},
            {"min_particles", CountOption{&min_particles_}},
            {"manager", FlagOption{&manager_}},
            smoothing(),
            over()};
  }
  /// Returns the orders of all pairs of neighbours.
  Plan plan(const LoadTable& table) const override;
  bool decentralised() const override { return true; }
  bool unmanaged() const override { return !manager_; }
  Order between(std::int32_t left, const Load& left_load, const Load& right_load) const override;

 private:
  // Nothing moves if times differ by less than this fraction of the longer one, or by less than noise can explain.
  double threshold_ = 0.005;
  double rate_ = 0.8;
  std::uint64_t min_particles_ = 64;  // nothing moves if fewer would
  // True: the manager finds neighbours that differ and brings them together. False: all neighbours compare their loads
  // in each frame.
  bool manager_ = true;
};

inline Order Diffusive::between(std::int32_t left, const Load& left_load, const Load& right_load) const {
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

inline Plan Diffusive::plan(const LoadTable& table) const {
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
