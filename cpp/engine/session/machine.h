// The machine that a rank runs on: how compute time is measured, slowed down for experiments, or simulated.
#pragma once

#include "comm/clock.h"
#include "engine/session/settings.h"
#include "threads/pool.h"

namespace motes::engine {

class Machine {
 public:
  /// The pool must outlive it.
  Machine(const Settings& settings, const threads::Pool& pool)
      : wall_clock_(settings.wall_clock), speed_(settings.speed), costs_(settings.costs), pool_(&pool) {}

  const Costs& costs() const { return costs_; }

  /// Seconds of work so far, by the clock that the run chose. What n threads do at the same time counts as the n-th
  /// part of their processor time: a rank with four threads is four times as fast.
  double compute_seconds() const {
    if (wall_clock_) return comm::wall_seconds();
    return comm::cpu_seconds() + (comm::simulated() ? 0 : pool_->beyond_caller_s());
  }

  /// Spends the extra time that a slower machine would have taken for the work since `start`.
  void slow_down(double start) const {
    if (speed_ < 1) comm::spend((compute_seconds() - start) * (1 / speed_ - 1));
  }

  /// Does some work as this machine does, and returns the compute seconds that it took.
  template <class Work>
  double timed(const Work& work) const {
    const double start = compute_seconds();
    work();
    slow_down(start);
    return compute_seconds() - start;
  }

  /// Under a simulator, lets the time pass that this work takes on a machine of speed 1, where each computed particle
  /// stands for `scale` others. Elsewhere nothing happens.
  void charge(double nanoseconds) const { comm::execute(nanoseconds * costs_.messages.scale); }

  /// Charges the cost of work that does not grow with the number of particles.
  void charge_once(double nanoseconds) const { comm::execute(nanoseconds); }

 private:
  bool wall_clock_;
  double speed_;
  Costs costs_;
  const threads::Pool* pool_;
};

}  // namespace motes::engine
