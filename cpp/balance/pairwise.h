// The paper's balancing (3.2.5): the manager evaluates pairs of neighbours.
#pragma once

#include "balance/policy.h"

namespace motes::balance {

/// Pairs (x, x + 1) from left to right, starting with the first pair and the second pair in turn. Where a pair (x, x +
/// 1) balances its load, the next pair considered is (x + 2, x + 3), so that each calculator only gives or only takes,
/// and with one neighbour.
class Pairwise : public Policy {
 public:
  static constexpr double kThreshold = 0.10;

  /// A pair balances where its times differ by more than `threshold` of the longer one, and by more than noise can
  /// explain, and at least `min_particles` would move: a smaller message costs more than the work it takes away.
  /// `powers` given, one per calculator, as in the paper: times are those of the last frame, as they were measured, and
  /// a pair divides its particles in proportion to its powers. Empty: both follow from measured speeds.
  Pairwise(double threshold, std::uint64_t min_particles, std::vector<double> powers = {})
      : threshold_(threshold), min_particles_(min_particles), powers_(std::move(powers)) {}

  std::string name() const override;
  Plan plan(const Table& table) const override;
  void check(std::size_t calculators) const override;

 private:
  bool apart(const Load& l, const Load& r, double left_speed, double right_speed) const;

  double threshold_;
  std::uint64_t min_particles_;
  std::vector<double> powers_;
};

}  // namespace motes::balance
