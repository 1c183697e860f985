// How much load: what is known about the work of one system, calculator by calculator (paper 3.2.4).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace motes::balance {

/// One system, or the sum of all, on one calculator, after the exchange of a frame.
struct Load {
  std::uint64_t particles = 0;
  double seconds = 0;  // from the first action to the last, rescaled to these particles
  double speed = 0;    // particles per second, smoothed; 0: not known
  double error = 0;    // relative standard error of the speed, from the samples' noise; 0: not known
};

template <class Visitor>
constexpr void fields(Visitor& visit, Load& load) {
  visit(load.particles, load.seconds, load.speed, load.error);
}

/// Processing time in proportion to the particles held after the exchange (paper 3.2.4).
double rescaled(double seconds, std::uint64_t processed, std::uint64_t after);

/// What counts as a sample of speed, and how samples become a speed.
struct SpeedOptions {
  double smoothing = 0.5;       // weight of the old value where speeds change, 0..1
  double min_seconds = 5e-5;    // shorter samples say more about the clock than about the machine
  std::uint64_t min_particles = 1000;
};

/// Smoothed speeds of calculators, and how well they are known. A sample is the median of three, since a disturbance
/// makes a machine slower for a frame. On a shared machine each measurement is off by some per cent. While samples
/// agree with the known speed up to their noise, the known speed weighs more, 1 - (1 - smoothing)^3, and at first all
/// samples weigh the same. A sample beyond the noise counts only as far as noise reaches, until two samples in a row
/// show the change, or five where the speed was steady before: the speed is then that of the last few samples.
class Speeds {
 public:
  Speeds() = default;
  Speeds(int calculators, SpeedOptions options);

  /// Adds a sample; ignored where it is too small, or where most of its particles are `newborn`: such a sample says
  /// more about memory that is touched for the first time than about the machine.
  void add(int calculator, std::uint64_t particles, double seconds, std::uint64_t newborn = 0);

  /// Particles per second; 0 where no sample was large enough yet.
  double of(int calculator) const { return known_[static_cast<std::size_t>(calculator)].steady.value; }

  /// Relative standard error of that speed; 0 before the third sample, and too low for the first hundred: an early
  /// order by mistake costs little, and a late one leaves a machine idle.
  double error(int calculator) const;

 private:
  struct Mean {
    double value = 0;
    double variance = 0;  // of the value, in variances of a sample
    double samples = 0;

    void add(double sample, double gain);
    double error(double noise2) const;
  };
  struct Known {
    Mean quick, steady;
    std::array<double, 2> last{};  // the latest samples, unfiltered; 0: none
    int lasting = 0;    // samples in a row that show a change; below 0: to a lower speed
    double noise2 = 0;  // mean square of a sample's relative error
    double steps = 0;   // number of samples in noise2

    void add(double raw, double gain);
    double undisturbed(double sample);
    double believed(double sample) const;
    void note(double square);
  };

  // Samples so far; the options are the run's.
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

/// Speeds without gaps: an unknown speed becomes the mean of the known ones, or all become 1 where none is known.
std::vector<double> complete(const std::vector<Load>& loads);

/// Predicted seconds of each calculator, from particles and complete speeds.
std::vector<double> predicted_seconds(const std::vector<Load>& loads);

/// By how much two calculators' times must differ, relative to the longer one, to be more than noise: a number of
/// standard errors of their difference.
inline constexpr double kErrors = 3;
double doubt(const Load& a, const Load& b);

/// Whether two calculators' times differ by more than `threshold` of the longer one, and by more than noise can
/// explain.
bool apart(const Load& a, double a_s, const Load& b, double b_s, double threshold);

/// The slowest calculator's predicted seconds divided by the mean; 1 where all are idle.
double imbalance(const std::vector<Load>& loads);

/// The sum of all systems' loads, calculator by calculator. Its speed covers the particles whose speed is known: their
/// number divided by the sum of their times.
std::vector<Load> sum_of(const std::vector<std::vector<Load>>& systems);

}  // namespace motes::balance
