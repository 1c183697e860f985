#include "balance/load.h"

#include <algorithm>
#include <cmath>

namespace motes::balance {

double rescaled(double seconds, std::uint64_t processed, std::uint64_t after) {
  return processed == 0 ? seconds : seconds * static_cast<double>(after) / static_cast<double>(processed);
}

Speeds::Speeds(int calculators, SpeedOptions options)
    : options_(options), speeds_(static_cast<std::size_t>(calculators), 0.0) {}

void Speeds::add(int calculator, std::uint64_t particles, double seconds) {
  const bool tells = std::isfinite(seconds) && seconds > 0 && seconds >= options_.min_seconds && particles > 0 &&
                     particles >= options_.min_particles;
  if (!tells) return;
  double& speed = speeds_[static_cast<std::size_t>(calculator)];
  const double sample = static_cast<double>(particles) / seconds;
  speed = speed > 0 ? options_.smoothing * speed + (1 - options_.smoothing) * sample : sample;
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

double imbalance(const std::vector<Load>& loads) {
  const std::vector<double> speeds = complete(loads);
  double sum = 0;
  double slowest = 0;
  for (std::size_t c = 0; c < loads.size(); ++c) {
    const double seconds = static_cast<double>(loads[c].particles) / speeds[c];
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
    for (const std::vector<Load>& loads : systems) {
      const Load& load = loads[c];
      sum[c].particles += load.particles;
      sum[c].seconds += load.seconds;
      if (!(load.speed > 0)) continue;
      timed += static_cast<double>(load.particles);
      takes += static_cast<double>(load.particles) / load.speed;
    }
    sum[c].speed = takes > 0 ? timed / takes : 0;
  }
  return sum;
}

}  // namespace motes::balance
