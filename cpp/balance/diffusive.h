// Load that flows like heat: neighbours decide between themselves. This is the paper's future work
// (section 6); for first-order diffusion see G. Cybenko, "Dynamic load balancing for distributed memory
// multiprocessors", Journal of Parallel and Distributed Computing 7 (1989).
#pragma once

#include "balance/policy.h"

namespace motes::balance {

class Diffusive : public Policy {
 public:
  static constexpr double kThreshold = 0.005;
  static constexpr double kRate = 0.8;

  /// Moves over each cut `rate` times half the difference in time, at the speed of the slower neighbour: stable for any
  /// speeds up to rate 1, and never more than half of the donor's particles over one cut. Nothing moves where times
  /// differ by less than `threshold` of the longer one, or by less than noise can explain, or where fewer than
  /// `min_particles` would move. With a manager, that one sees which neighbours differ and brings them together;
  /// without, all neighbours compare their loads in each frame.
  Diffusive(double threshold, double rate, std::uint64_t min_particles, bool manager = true)
      : threshold_(threshold), rate_(rate), min_particles_(min_particles), manager_(manager) {}

  std::string name() const override;
  /// What all pairs of neighbours decide together.
  Plan plan(const Table& table) const override;
  bool decentralised() const override { return true; }
  bool unmanaged() const override { return !manager_; }
  Order between(std::int32_t left, const Load& left_load, const Load& right_load) const override;

 private:
  double threshold_;
  double rate_;
  std::uint64_t min_particles_;
  bool manager_;
};

}  // namespace motes::balance
