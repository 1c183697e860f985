// A policy from its name, as Policy::name() returns it and as logs, scenes and command lines store it.
#pragma once

#include <string>

#include "balance/policy.h"

namespace motes::balance {

/// "Pairwise(threshold=0.1, min_particles=64)", "PrefixCuts()", "Static": options that are left out have the defaults
/// of python/motes/balance/__init__.py. Throws std::invalid_argument for an unknown name or option, which includes balancers
/// that a script defines itself.
PolicyPtr policy_named(const std::string& name);

}  // namespace motes::balance
