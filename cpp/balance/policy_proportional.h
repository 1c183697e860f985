// Fixed shares of the particles, independent of measured times.
#pragma once

#include <cmath>

#include "balance/policy.h"
#include "balance/shares.h"

namespace motes::balance {

/// Gives each calculator particles in proportion to its power. Sets new cuts if one is off by more than `threshold` of
/// its share and by at least `min_particles`.
class Proportional : public Policy {
 public:
  const char* kind() const override { return "Proportional"; }
  Options options() override {
    return {{"powers", PowersOption{&powers_, true}},
            {"threshold", NumberOption{&threshold_}},
            {"min_particles", CountOption{&min_particles_}},
            over()};
  }
  Plan plan(const LoadTable& table) const override;
  void check(std::size_t calculators) const override { check_powers(*this, powers_, calculators); }

 private:
  std::vector<double> powers_;
  double threshold_ = 0.05;
  std::uint64_t min_particles_ = 64;
};

inline Plan Proportional::plan(const LoadTable& table) const {
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
