#include "comm/clock.h"

#include <time.h>

namespace motes::comm {
namespace {

thread_local TimeSource* source = nullptr;

double seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

void set_time_source(TimeSource* of_this_thread) { source = of_this_thread; }

bool simulated() { return source != nullptr; }

double wall_seconds() { return source != nullptr ? source->now_s() : seconds(CLOCK_MONOTONIC); }

double cpu_seconds() { return source != nullptr ? source->now_s() : seconds(CLOCK_THREAD_CPUTIME_ID); }

void spend(double how_many) {
  if (source != nullptr) return source->spend(how_many);
  const double until = cpu_seconds() + how_many;
  while (cpu_seconds() < until) {
  }
}

void execute(double operations) {
  if (source != nullptr && operations > 0) source->execute(operations);
}

}  // namespace motes::comm
