// Loads: what is known about the work of a system on each calculator (paper 3.2.4).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace motes::balance {

/// The load of one system, or of all systems, on one calculator after the exchange of a frame.
struct Load {
  std::uint64_t particles = 0;
  double seconds = 0;  // from the first action to the last, rescaled to these particles
  double speed = 0;    // particles per second, smoothed; 0: unknown
  double error = 0;    // relative standard error of the speed, from the samples' noise; 0: unknown
};

template <class Visitor>
constexpr void fields(Visitor& visit, Load& load) {
  visit(load.particles, load.seconds, load.speed, load.error);
}

/// Returns the processing time in proportion to the particles held after the exchange (paper 3.2.4).
double rescaled(double seconds, std::uint64_t processed, std::uint64_t after);

/// Which samples count, and how they are smoothed.
struct SpeedOptions {
  double smoothing = 0.5;       // weight of the old value when speeds change, 0..1
  double min_seconds = 5e-5;    // shorter samples say more about the clock than about the machine
  std::uint64_t min_particles = 1000;
};

/// Smoothed speeds of calculators with their standard errors. A sample is the median of three, since a disturbance
/// makes a machine slower for a frame. On a shared machine each measurement is off by some per cent, so while samples
/// agree with the known speed up to their noise, that speed has more weight: 1 - (1 - smoothing)^3. The first samples
/// all weigh the same. A sample beyond the noise is clipped to the noise band, until two samples in a row (five if the
/// speed was steady) show a change; the speed is then that of the last few samples.
class Speeds {
 public:
  Speeds() = default;
  Speeds(int calculators, SpeedOptions options);

  /// Adds a sample. Ignores it if it is too small, or if most of its particles are `newborn`: such a sample measures
  /// first accesses to memory rather than the machine.
  void add(int calculator, std::uint64_t particles, double seconds, std::uint64_t newborn = 0);

  /// Returns the speed, particles per second; 0 before the first sample that is large enough.
  double of(int calculator) const { return known_[static_cast<std::size_t>(calculator)].steady.value; }

  /// Returns the relative standard error of that speed; 0 before the third sample. It is too low for the first hundred
  /// samples: a mistaken order costs less than an idle machine.
  double error(int calculator) const;

 private:
  struct Mean {
    double value = 0;
    double variance = 0;  // of the value, in units of a sample's variance
    double samples = 0;

    void add(double sample, double gain);
    double error(double noise2) const;
  };
  struct Known {
    Mean quick, steady;
    std::array<double, 2> last{};  // the latest samples, unfiltered; 0: none
    int lasting = 0;  // samples in a row that show a change; below 0: to a lower speed
    double noise2 = 0;  // mean square of a sample's relative error
    double steps = 0;  // number of samples in noise2

    void add(double raw, double gain);
    double undisturbed(double sample);
    double believed(double sample) const;
    void note(double square);
  };

  // Only the samples so far; the options are the run's.
  template <class Visitor>
  friend constexpr void fields(Visitor& visit, Mean& mean) {
    visit(mean.value, mean.variance, mean.samples);
  }
  template <class Visitor>
  friend constexpr void fields(Visitor& visit, Known& known) {
    visit(known.quick, known.steady, known.last, known.lasting, known.noise2, known.steps);
  }
  template <class Visitor>
  friend constexpr void fields(Visitor& visit, Speeds& speeds) {
    visit(speeds.known_);
  }

  SpeedOptions options_;
  std::vector<Known> known_;
};

/// Returns all speeds: an unknown one is the mean of the known ones, or 1 if none is known.
std::vector<double> complete(const std::vector<Load>& loads);

/// Returns the predicted seconds of each calculator, from its particles and its complete() speed.
std::vector<double> predicted_seconds(const std::vector<Load>& loads);

/// A difference of more than this many standard errors is more than noise.
inline constexpr double kErrors = 3;
/// Returns by how much two calculators' times must differ, relative to the longer one, to be more than noise.
double doubt(const Load& a, const Load& b);

/// Returns whether two calculators' times differ by more than `threshold` of the longer one and by more than noise can
/// explain.
bool apart(const Load& a, double a_s, const Load& b, double b_s, double threshold);

/// Returns the slowest calculator's predicted seconds divided by the mean; 1 if all are idle.
double imbalance(const std::vector<Load>& loads);

/// Sums the loads of all systems, calculator by calculator. The speed covers only particles whose speed is known: their
/// number divided by the sum of their times.
std::vector<Load> sum_of(const std::vector<std::vector<Load>>& systems);

}  // namespace motes::balance
