// A simulated rank's clock, and the random numbers that vary how long things take.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "base/hash.h"
#include "comm/clock.h"

namespace motes::comm::simulation {

inline constexpr double kNotYet = -1;
inline constexpr double kNever = 1e300;

/// SplitMix64 (Steele, Lea, Flood 2014, "Fast splittable pseudorandom number generators").
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() { return base::next_random(state_); }
  std::size_t below(std::size_t end) { return static_cast<std::size_t>(next() % end); }
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }

 private:
  std::uint64_t state_;
};

inline std::uint64_t mixed(std::uint64_t a, std::uint64_t b) { return Random(a * 0x2545f4914f6cdd1du + b).next(); }

struct SimulatedMachine final : TimeSource {
  int number = 0;  // the rank's number among all ranks
  double clock_s = 0;
  double died_s = kNever;
  double operation_s = 1e-9;
  double variation = 0;
  Random timing{0};

  bool live() const { return died_s == kNever; }
  double varied(double seconds) { return seconds * (1 + variation * (2 * timing.unit() - 1)); }
  double now_s() const override { return clock_s; }
  void spend(double seconds) override { clock_s += std::max(seconds, 0.0); }
  void execute(double operations) override { clock_s += varied(operations * operation_s); }
};

}  // namespace motes::comm::simulation
