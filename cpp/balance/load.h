// How much: what is known of the work of one system, a calculator at a time (paper 3.2.4).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace motes::balance {

/// One system, or the sum of all, on one calculator, after the exchange of a frame.
struct Load {
  std::uint64_t particles = 0;
  double seconds = 0;  // from the first action to the last, rescaled to these particles
  double speed = 0;    // particles a second, smoothed; 0: not known
  double error = 0;    // the speed's standard error as a part of it, by the samples' noise; 0: not known
};

template <class Visitor>
constexpr void fields(Visitor& visit, Load& load) {
  visit(load.particles, load.seconds, load.speed, load.error);
}

/// Processing time in proportion to the particles held after the exchange (paper 3.2.4).
double rescaled(double seconds, std::uint64_t processed, std::uint64_t after);

/// What makes a sample of speed, and how samples become a speed.
struct SpeedOptions {
  double smoothing = 0.5;       // weight of what was known where speeds change, 0..1
  double min_seconds = 5e-5;    // shorter samples say more about the clock than about the machine
  std::uint64_t min_particles = 1000;
};

/// Smoothed speeds of calculators, and how well they are known. A sample is the middle one of three, since what
/// disturbs a machine makes it slower for a frame. A clock on a shared machine is off by some per cent in each: while
/// samples agree with what was known but for their noise, it weighs more, 1 - (1 - smoothing)^3, and all samples alike
/// at first; what is beyond noise counts as far as noise reaches, until two samples on end show it, or five where the
/// speed was steady before: the speed is then that of the last few.
class Speeds {
 public:
  Speeds() = default;
  Speeds(int calculators, SpeedOptions options);

  /// A sample; ignored where it is too small, or most of its particles are `newborn`: then it says more about memory
  /// that is touched for the first time than about the machine.
  void add(int calculator, std::uint64_t particles, double seconds, std::uint64_t newborn = 0);

  /// Particles a second; 0 where no sample was large enough yet.
  double of(int calculator) const { return known_[static_cast<std::size_t>(calculator)].steady.value; }

  /// Standard error of that, as a part of it; 0 before the third sample, and less than it is for the first hundred:
  /// an early order by mistake costs little, and a late one leaves a machine idle.
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
    std::array<double, 2> last{};  // samples as they came; 0: none
    int lasting = 0;    // samples on end that show a change; below 0: to slower
    double noise2 = 0;  // mean square of a sample's error, as a part of it
    double steps = 0;   // samples that noise2 is of

    void add(double raw, double gain);
    double undisturbed(double sample);
    double believed(double sample) const;
    void note(double square);
  };

  SpeedOptions options_;
  std::vector<Known> known_;
};

/// Speeds without gaps: what is not known is the mean of what is, or 1 for all where nothing is.
std::vector<double> complete(const std::vector<Load>& loads);

/// Predicted seconds of each calculator, from particles and complete speeds.
std::vector<double> predicted_seconds(const std::vector<Load>& loads);

/// How far apart two calculators' times must be, as a part of the longer one, to be more than noise: so many standard
/// errors of their difference.
inline constexpr double kErrors = 3;
double doubt(const Load& a, const Load& b);

/// Whether two calculators' times differ by more than `threshold` of the longer one, and by more than noise may
/// explain.
bool apart(const Load& a, double a_s, const Load& b, double b_s, double threshold);

/// The slowest calculator's predicted seconds over the mean; 1 where all are idle.
double imbalance(const std::vector<Load>& loads);

/// All systems' loads, calculator by calculator. The speed of a mix is its particles over the sum of what each part
/// takes, where that is known.
std::vector<Load> sum_of(const std::vector<std::vector<Load>>& systems);

}  // namespace motes::balance
