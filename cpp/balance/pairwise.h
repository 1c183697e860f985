// The paper's balancing (3.2.5): the manager evaluates pairs of neighbours.
#pragma once

#include "balance/policy.h"

namespace motes::balance {

/// Pairs (x, x + 1) from left to right, the first pair every other time the second; where a pair balances its load, the
/// next pair that could is the one after, so that each calculator only gives or only takes, and with one neighbour.
class Pairwise : public Policy {
 public:
  static constexpr double kThreshold = 0.10;

  /// A pair balances where its times differ by more than `threshold` of the longer one, and by more than noise may
  /// explain, and at least `min_particles` are to be moved: a message of fewer costs more than the work it takes away.
  Pairwise(double threshold, std::uint64_t min_particles) : threshold_(threshold), min_particles_(min_particles) {}

  std::string name() const override;
  Plan plan(const Table& table) const override;

 private:
  double threshold_;
  std::uint64_t min_particles_;
};

}  // namespace motes::balance
