// Creates a policy from its name, as Policy::name() returns it and logs, scenes and command lines store it.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "balance/policy.h"

namespace motes::balance {

/// Returns the names of all policies of the core.
const std::vector<std::string>& policy_names();

/// Returns a policy with its defaults. Throws std::invalid_argument if no policy has this name.
std::shared_ptr<Policy> policy_made(const std::string& kind);
/// Returns a policy with options. Throws std::invalid_argument if an option does not exist or its value is not allowed.
std::shared_ptr<Policy> policy_made(const std::string& kind, const std::map<std::string, Value>& options);

/// Returns the policy of a call: "Pairwise(threshold=0.1, min_particles=64)", "PrefixCuts()", "Static". Omitted options
/// have their defaults. Throws std::invalid_argument for an unknown name or option; the names of a script's own
/// balancers are unknown.
std::shared_ptr<Policy> policy_named(const std::string& call);

}  // namespace motes::balance
