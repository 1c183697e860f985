#include "balance/load.h"

#include <algorithm>
#include <cmath>

namespace motes::balance {

namespace {

constexpr double kNoiseGain = 0.05;  // weight of a new sample in the noise estimate, after twenty samples
constexpr double kLeastNoise = 0.01;  // lower bound in the long run: no clock is better
constexpr double kFirstNoise = 0.05;  // lower bound for the first samples
constexpr double kMostNoise = 0.2;  // upper bound: with more noise, waiting for certainty would cost more than errors

// A change counts only if this many samples in a row show it: a disturbance of a few frames would end before moving
// particles because of it paid off.
constexpr double kFirstLasting = 2;  // for a speed known from few samples
constexpr double kLasting = 5;  // for a speed that was steady for kSteady samples
constexpr double kSteady = 24;
constexpr double kFew = 8;  // fewer samples do not reveal the noise

}  // namespace

double rescaled(double seconds, std::uint64_t processed, std::uint64_t after) {
  return processed == 0 ? seconds : seconds * static_cast<double>(after) / static_cast<double>(processed);
}

Speeds::Speeds(int calculators, SpeedOptions options)
    : options_(options), known_(static_cast<std::size_t>(calculators)) {}

void Speeds::add(int calculator, std::uint64_t particles, double seconds, std::uint64_t newborn) {
  const bool tells = std::isfinite(seconds) && seconds > 0 && seconds >= options_.min_seconds && particles > 0 &&
                     particles >= options_.min_particles && newborn <= particles / 2;
  if (!tells) return;
  known_[static_cast<std::size_t>(calculator)].add(static_cast<double>(particles) / seconds, 1 - options_.smoothing);
}

// Disturbances make a machine slower for a frame, so this is the faster of the first two samples, then the median of
// three.
double Speeds::Known::undisturbed(double sample) {
  const double a = last[0];
  const double b = last[1];
  last = {b, sample};
  if (!(b > 0)) return sample;
  if (!(a > 0)) {
    quick = steady = {};  // the first sample is from a cold machine
    return std::max(b, sample);
  }
  return std::max(std::min(a, b), std::min(std::max(a, b), sample));
}

void Speeds::Known::add(double raw, double gain) {
  const double sample = undisturbed(raw);
  double off = 0;
  if (steady.value > 0) {
    off = sample / steady.value - 1;
    const double odd = raw / quick.value - 1;  // drift is not noise: the average of the last few samples follows it
    note(odd * odd / (1 + quick.variance));
  }
  quick.add(sample, gain);
  steady.add(gain < 1 ? believed(sample) : sample, gain * gain * gain);  // without smoothing, samples count fully
  const double change = quick.value / steady.value - 1;
  const int side = change > 0 ? 1 : -1;
  const bool shows = std::abs(change) > kErrors * quick.error(noise2) && off * change > change * change / 2;
  lasting = shows ? side + (lasting * side > 0 ? lasting : 0) : 0;
  const double enough = std::min(kFirstLasting + (kLasting - kFirstLasting) * steps / kSteady, kLasting);
  if (std::abs(lasting) < enough) return;
  steady = quick;
  lasting = 0;
}

// Clips a sample to the noise band around the known speed, until a change proves to last.
double Speeds::Known::believed(double sample) const {
  if (steps < kFew) return sample;
  const double reach = steady.value * kErrors * std::max(std::sqrt(noise2), kLeastNoise);
  return std::clamp(sample, steady.value - reach, steady.value + reach);
}

// Updates the noise. A value far beyond the noise so far is a change or an accident, and is clipped.
void Speeds::Known::note(double square) {
  const double least = steps < 4 ? kFirstNoise : kLeastNoise;
  const double most = kErrors * kErrors * std::max(noise2, least * least);
  noise2 += std::max(kNoiseGain, 1 / ++steps) * (std::min(square, most) - noise2);
  noise2 = std::min(noise2, kMostNoise * kMostNoise);
}

double Speeds::error(int calculator) const {
  const Known& known = known_[static_cast<std::size_t>(calculator)];
  // Among a hundred samples, one or two differ by three standard errors by chance; among two samples none does.
  const double looks = std::min(1.0, std::sqrt(2 * std::log1p(known.steps)) / kErrors);
  return looks * known.steady.error(known.noise2);
}

void Speeds::Mean::add(double sample, double gain) {
  const double weight = std::max(gain, 1 / (samples + 1));
  value += weight * (sample - value);
  variance = (1 - weight) * (1 - weight) * variance + weight * weight;
  samples = 1 / variance;
}

double Speeds::Mean::error(double noise2) const { return std::sqrt(noise2 * variance); }

double doubt(const Load& a, const Load& b) { return kErrors * std::hypot(a.error, b.error); }

bool apart(const Load& a, double a_s, const Load& b, double b_s, double threshold) {
  const double least = std::max(threshold, doubt(a, b));
  return std::abs(a_s - b_s) > least * std::max(a_s, b_s);
}

std::vector<double> complete(const std::vector<Load>& loads) {
  double sum = 0;
  std::size_t known = 0;
  for (const Load& load : loads) {
    if (!(load.speed > 0) || !std::isfinite(load.speed)) continue;
    sum += load.speed;
    ++known;
  }
  const double mean = known > 0 ? sum / static_cast<double>(known) : 1;
  std::vector<double> speeds;
  speeds.reserve(loads.size());
  for (const Load& load : loads) speeds.push_back(load.speed > 0 && std::isfinite(load.speed) ? load.speed : mean);
  return speeds;
}

std::vector<double> predicted_seconds(const std::vector<Load>& loads) {
  std::vector<double> seconds = complete(loads);
  for (std::size_t c = 0; c < loads.size(); ++c) seconds[c] = static_cast<double>(loads[c].particles) / seconds[c];
  return seconds;
}

double imbalance(const std::vector<Load>& loads) {
  double sum = 0;
  double slowest = 0;
  for (const double seconds : predicted_seconds(loads)) {
    sum += seconds;
    slowest = std::max(slowest, seconds);
  }
  return sum > 0 ? slowest * static_cast<double>(loads.size()) / sum : 1;
}

std::vector<Load> sum_of(const std::vector<std::vector<Load>>& systems) {
  std::vector<Load> sum(systems.empty() ? 0 : systems.front().size());
  for (std::size_t c = 0; c < sum.size(); ++c) {
    double timed = 0;  // particles whose speed is known
    double takes = 0;
    double errors = 0;  // assumes errors of the same sign, as the systems share a processor
    for (const std::vector<Load>& loads : systems) {
      const Load& load = loads[c];
      sum[c].particles += load.particles;
      sum[c].seconds += load.seconds;
      if (!(load.speed > 0)) continue;
      timed += static_cast<double>(load.particles);
      const double seconds = static_cast<double>(load.particles) / load.speed;
      takes += seconds;
      errors += seconds * load.error;
    }
    sum[c].speed = takes > 0 ? timed / takes : 0;
    sum[c].error = takes > 0 ? errors / takes : 0;
  }
  return sum;
}

}  // namespace motes::balance
