// How much: what is known of the work of one system, a calculator at a time (paper 3.2.4).
#pragma once

#include <cstdint>
#include <vector>

namespace motes::balance {

/// One system, or the sum of all, on one calculator, after the exchange of a frame.
struct Load {
  std::uint64_t particles = 0;
  double seconds = 0;  // from the first action to the last, rescaled to these particles
  double speed = 0;    // particles a second, smoothed; 0: not known
};

/// Processing time in proportion to the particles held after the exchange (paper 3.2.4).
double rescaled(double seconds, std::uint64_t processed, std::uint64_t after);

/// What makes a sample of speed, and how samples become a speed.
struct SpeedOptions {
  double smoothing = 0.5;       // weight of what was known, 0..1
  double min_seconds = 2e-4;    // shorter samples say more about the clock than about the machine
  std::uint64_t min_particles = 1000;
};

/// Smoothed speeds of calculators.
class Speeds {
 public:
  Speeds() = default;
  Speeds(int calculators, SpeedOptions options);

  /// A sample; ignored where it is too small.
  void add(int calculator, std::uint64_t particles, double seconds);

  /// Particles a second; 0 where no sample was large enough yet.
  double of(int calculator) const { return speeds_[static_cast<std::size_t>(calculator)]; }

 private:
  SpeedOptions options_;
  std::vector<double> speeds_;
};

/// Speeds without gaps: what is not known is the mean of what is, or 1 for all where nothing is.
std::vector<double> complete(const std::vector<Load>& loads);

/// The slowest calculator's predicted seconds over the mean, from particles and complete speeds; 1 where all are idle.
double imbalance(const std::vector<Load>& loads);

/// All systems' loads, calculator by calculator. The speed of a mix is its particles over the sum of what each part
/// takes, where that is known.
std::vector<Load> sum_of(const std::vector<std::vector<Load>>& systems);

}  // namespace motes::balance
