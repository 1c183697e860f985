#include "balance/shares.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/invalid_argument.h"

namespace motes::balance {

std::vector<double> wanted(const std::vector<Load>& loads, const std::vector<double>& shares,
                           const std::vector<double>& costs) {
  double cost = 0;
  double parts = 0;
  for (std::size_t c = 0; c < loads.size(); ++c) {
    cost += static_cast<double>(loads[c].particles) * (costs.empty() ? 1 : costs[c]);
    parts += shares[c];
  }
  std::vector<double> wanted;
  wanted.reserve(loads.size());
  for (std::size_t c = 0; c < loads.size(); ++c) {
    wanted.push_back(cost * (shares[c] / parts) / (costs.empty() ? 1 : costs[c]));
  }
  return wanted;
}

double most_off(const std::vector<Load>& loads, const std::vector<double>& wanted) {
  double most = 0;
  for (std::size_t c = 0; c < loads.size(); ++c) {
    most = std::max(most, std::abs(static_cast<double>(loads[c].particles) - wanted[c]));
  }
  return most;
}

bool above_mean(const std::vector<Load>& loads, double threshold) {
  const std::vector<double> seconds = predicted_seconds(loads);
  const auto calculators = static_cast<double>(loads.size());
  const double sum = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  const double errors = std::sqrt(kErrors * kErrors + 2 * std::log(std::max(calculators, 1.0)));
  for (std::size_t c = 0; c < loads.size(); ++c) {
    const double least = std::max(threshold, errors * loads[c].error);
    if (sum > 0 && seconds[c] * calculators / sum > 1 + least) return true;
  }
  return false;
}

void check_powers(const Policy& policy, const std::vector<double>& powers, std::size_t calculators) {
  if (powers.size() == calculators) return;
  throw base::InvalidArgument("powers", "be " + std::to_string(calculators) + " numbers, one per calculator",
                              std::to_string(powers.size()), policy.name());
}

}  // namespace motes::balance
