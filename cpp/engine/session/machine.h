// The machine that a rank runs on: how compute time is measured, slowed down for experiments, or simulated.
#pragma once

#include "comm/clock.h"
#include "engine/session/settings.h"
#include "threads/pool.h"

namespace motes::engine {

class Machine {
 public:
  /// The pool must outlive the machine.
  Machine(const Settings& settings, const threads::Pool& pool)
      : wall_clock_(settings.wall_clock), speed_(settings.speed), costs_(settings.costs), pool_(&pool) {}

  void set_speed(double speed) { speed_ = speed; }

  const Costs& costs() const { return costs_; }

  /// Returns the seconds of work so far, by the clock chosen for the run. CPU time is divided by the number of threads:
  /// a rank with four threads is four times as fast.
  double compute_seconds() const {
    if (wall_clock_) return comm::wall_seconds();
    return comm::cpu_seconds() + (comm::simulated() ? 0 : pool_->beyond_caller_s());
  }

  /// Spends the extra time that a slower machine would have needed for the work since `start`.
  void slow_down(double start) const {
    if (speed_ < 1) comm::spend((compute_seconds() - start) * (1 / speed_ - 1));
  }

  /// Runs `work` at this machine's speed, and returns the compute seconds that it took.
  template <class Work>
  double timed(const Work& work) const {
    const double start = compute_seconds();
    work();
    slow_down(start);
    return compute_seconds() - start;
  }

  /// Under a simulator, advances the clock by the time of this work, given for a machine of speed 1 and multiplied by
  /// `messages.scale`. No effect elsewhere.
  void charge(double nanoseconds) const { comm::execute(nanoseconds * costs_.messages.scale); }

  /// Charges work that does not grow with the number of particles: like charge(), without `messages.scale`.
  void charge_once(double nanoseconds) const { comm::execute(nanoseconds); }

 private:
  bool wall_clock_;
  double speed_;
  Costs costs_;
  const threads::Pool* pool_;
};

}  // namespace motes::engine
