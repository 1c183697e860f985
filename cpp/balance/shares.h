// How far calculators are from the shares they should have.
#pragma once

#include <vector>

#include "balance/policy.h"

namespace motes::balance {

/// Returns how many particles each calculator should hold, at the cost of its own domain; costs empty: 1 each.
std::vector<double> wanted(const std::vector<Load>& loads, const std::vector<double>& shares,
                           const std::vector<double>& costs);

/// Returns the largest difference between what a calculator holds and what it should hold, in particles.
double most_off(const std::vector<Load>& loads, const std::vector<double>& wanted);

/// Returns whether some calculator's predicted seconds are above the mean by more than `threshold` of it and by more
/// than noise can explain, given that the largest of many errors exceeds a single one.
bool above_mean(const std::vector<Load>& loads, double threshold);

/// Throws std::invalid_argument naming the policy unless there is one power per calculator.
void check_powers(const Policy& policy, const std::vector<double>& powers, std::size_t calculators);

}  // namespace motes::balance
