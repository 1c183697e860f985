// Load that flows like heat: neighbours decide by themselves, no manager in between. The paper's future work
// (section 6); first-order diffusion is G. Cybenko, "Dynamic load balancing for distributed memory multiprocessors",
// Journal of Parallel and Distributed Computing 7 (1989).
#pragma once

#include "balance/policy.h"

namespace motes::balance {

class Diffusive : public Policy {
 public:
  static constexpr double kThreshold = 0.005;
  static constexpr double kRate = 0.8;

  /// Over each cut goes `rate` times half the difference in time, at the speed of the slower one: stable for any
  /// speeds up to rate 1, and never more than half of what the donor has over one cut. Nothing goes where times differ
  /// by less than `threshold` of the longer one, or than noise may explain, or fewer than `min_particles` would.
  Diffusive(double threshold, double rate, std::uint64_t min_particles)
      : threshold_(threshold), rate_(rate), min_particles_(min_particles) {}

  std::string name() const override;
  /// What all neighbours decide together.
  Plan plan(const Table& table) const override;
  bool decentralised() const override { return true; }
  Order between(std::int32_t left, const Load& left_load, const Load& right_load) const override;

 private:
  double threshold_;
  double rate_;
  std::uint64_t min_particles_;
};

}  // namespace motes::balance
