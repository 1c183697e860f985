// The engine's only clock: the machine's, unless a simulator keeps the time.
#pragma once

namespace motes::comm {

/// Whether the calling thread's time is simulated: it passes by spend(), execute() and messages alone.
bool simulated();

/// Seconds since some moment in the past. Never goes back.
double wall_seconds();

/// Seconds of processor time that this thread has used. Unlike wall time it is not stretched by other processes.
/// Under a simulator: the simulated time.
double cpu_seconds();

/// Keeps this thread busy until it has used so many seconds of processor time more.
void spend(double seconds);

/// Under a simulator, lets the time pass that this rank's machine takes for so many operations; nothing otherwise.
void execute(double operations);

/// Who keeps the time under a simulator.
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

/// From now on the calling thread has its time from `source`; null: from the machine.
void set_time_source(TimeSource* source);

}  // namespace motes::comm
