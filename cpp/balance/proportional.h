// Fixed shares of the particles, independent of measured times.
#pragma once

#include "balance/policy.h"

namespace motes::balance {

class Proportional : public Policy {
 public:
  static constexpr double kThreshold = 0.05;

  /// Each calculator holds particles in proportion to its power. Sets new cuts where one is off by more than
  /// `threshold` of its share, and by at least `min_particles`.
  Proportional(std::vector<double> powers, double threshold, std::uint64_t min_particles)
      : powers_(std::move(powers)), threshold_(threshold), min_particles_(min_particles) {}

  std::string name() const override;
  Plan plan(const Table& table) const override;
  void check(std::size_t calculators) const override;

 private:
  std::vector<double> powers_;
  double threshold_;
  std::uint64_t min_particles_;
};

}  // namespace motes::balance
