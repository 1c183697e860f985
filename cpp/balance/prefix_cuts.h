// All cuts at once, from global prefix sums of cost along the axis: particles may jump over several domains.
#pragma once

#include "balance/policy.h"

namespace motes::balance {

class PrefixCuts : public Policy {
 public:
  static constexpr double kThreshold = 0.05;

  /// New cuts where a calculator is more than `threshold` above the mean, and more than noise may explain, and some
  /// calculator is at least `min_particles` off. `powers` empty: what a particle costs belongs to the machine, and each
  /// calculator gets particles by its measured speed. `powers` given, one a calculator: the machines are known, what a
  /// particle costs belongs to the place, and each calculator gets that part of all cost.
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
