// All cuts at once, from global prefix sums of cost along the axis: particles may move across several domains.
#pragma once

#include "balance/policy.h"

namespace motes::balance {

class PrefixCuts : public Policy {
 public:
  static constexpr double kThreshold = 0.05;

  /// Sets new cuts where a calculator is more than `threshold` above the mean, and by more than noise can explain, and
  /// some calculator is off by at least `min_particles`. `powers` empty: the cost of a particle depends on the machine,
  /// and each calculator gets particles by its measured speed. `powers` given, one per calculator: the machines are
  /// known, the cost of a particle depends on the place, and each calculator gets its power's share of the total cost.
  PrefixCuts(double threshold, std::vector<double> powers, std::uint64_t min_particles)
      : threshold_(threshold), powers_(std::move(powers)), min_particles_(min_particles) {}

  std::string name() const override;
  Plan plan(const Table& table) const override;
  void check(std::size_t calculators) const override;

 private:
  std::vector<double> costs(const std::vector<Load>& loads) const;

  double threshold_;
  std::vector<double> powers_;
  std::uint64_t min_particles_;
};

}  // namespace motes::balance
