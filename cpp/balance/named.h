// A policy from its name, as Policy::name() gives it and logs, scenes and command lines hold it.
#pragma once

#include <string>

#include "balance/policy.h"

namespace motes::balance {

/// "Pairwise(threshold=0.1, min_particles=64)", "PrefixCuts()", "Static": options that are left out have the defaults
/// of python/motes/balance.py. Throws std::invalid_argument for a name or option that there is not: also for a balancer
/// that a script wrote itself.
PolicyPtr policy_named(const std::string& name);

}  // namespace motes::balance
