// Moves all cuts at once, if moving the particles costs less than the balance saves while it lasts.
#pragma once

#include <algorithm>

#include "balance/policy.h"
#include "balance/shares.h"

namespace motes::balance {

/// Sets shares in proportion to measured speeds, like PrefixCuts, if they save more time in `horizon` frames than the
/// calculator with the most particles to pack and unpack needs for them.
class CostAware : public Policy {
 public:
  const char* kind() const override { return "CostAware"; }
  Options options() override {
    return {{"move_cost", NumberOption{&move_cost_}},
            {"horizon", NumberOption{&horizon_}},
            {"min_particles", CountOption{&min_particles_}},
            smoothing(),
            over()};
  }
  Plan plan(const LoadTable& table) const override;

 private:
  // Returns the seconds that the busiest calculator needs to give and take particles until it holds its share.
  double moving_s(const LoadTable& table, const std::vector<double>& wants, const std::vector<double>& speeds) const;

  double move_cost_ = 1;  // the cost of giving or taking a particle, in frames of its actions
  double horizon_ = 20;   // frames that a balance lasts
  std::uint64_t min_particles_ = 64;
};

inline double CostAware::moving_s(const LoadTable& table, const std::vector<double>& wants,
                                  const std::vector<double>& speeds) const {
  double most = 0;
  double held_before = 0;
  double wanted_before = 0;
  for (std::size_t c = 0; c < wants.size(); ++c) {
    const auto held = static_cast<double>(table.loads[c].particles);
    double kept = std::min(held, wants[c]);
    if (table.axes.row()) {  // particles keep their order along the axis
      const double end = std::min(held_before + held, wanted_before + wants[c]);
      kept = std::max(0.0, end - std::max(held_before, wanted_before));
    }
    most = std::max(most, (held + wants[c] - 2 * kept) / speeds[c]);
    held_before += held;
    wanted_before += wants[c];
  }
  return most * move_cost_;
}

inline Plan CostAware::plan(const LoadTable& table) const {
  Plan plan;
  for (std::size_t i = 0; i + 1 < table.loads.size(); ++i) plan.evaluated.push_back(static_cast<std::int32_t>(i));
  if (table.loads.empty()) return plan;
  const std::vector<double> speeds = complete(table.loads);
  const std::vector<double> wants = wanted(table.loads, speeds, {});
  const std::vector<double> seconds = predicted_seconds(table.loads);
  const double saved = *std::max_element(seconds.begin(), seconds.end()) - wants[0] / speeds[0];
  if (above_mean(table.loads, 0) && most_off(table.loads, wants) >= static_cast<double>(min_particles_) &&
      saved * horizon_ > moving_s(table, wants, speeds))
    plan.shares = speeds;
  return plan;
}

}  // namespace motes::balance
