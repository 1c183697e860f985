// The engine's only clock: the machine's, or a simulator's.
#pragma once

namespace motes::comm {

/// Returns whether the calling thread's time is simulated: then only spend(), execute() and messages advance it.
bool simulated();

/// Returns the seconds since some fixed moment. Never decreases.
double wall_seconds();

/// Returns the CPU time that this thread has used, s. Unlike wall time, it is not stretched by other processes. Under a
/// simulator: the simulated time.
double cpu_seconds();

/// Keeps this thread busy for `seconds` of CPU time.
void spend(double seconds);

/// Under a simulator, advances the time by what this rank's machine needs for `operations`. Otherwise does nothing.
void execute(double operations);

/// The clock of a simulator.
class TimeSource {
 public:
  TimeSource() = default;
  virtual ~TimeSource() = default;
  TimeSource(const TimeSource&) = delete;
  TimeSource& operator=(const TimeSource&) = delete;

  virtual double now_s() const = 0;
  virtual void spend(double seconds) = 0;
  virtual void execute(double operations) = 0;
};

/// Makes the calling thread take its time from `source`; null: from the machine.
void set_time_source(TimeSource* source);

}  // namespace motes::comm
