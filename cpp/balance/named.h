// A policy from its name, as Policy::name() returns it and as logs, scenes and command lines store it.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "balance/policy.h"

namespace motes::balance {

/// The names of all policies of the core.
const std::vector<std::string>& policy_names();

/// A policy with its defaults; throws std::invalid_argument where no policy has this name.
std::shared_ptr<Policy> policy_made(const std::string& kind);
/// The same with options; throws base::InvalidArgument where it has no such option, or a value is not allowed.
std::shared_ptr<Policy> policy_made(const std::string& kind, const std::map<std::string, Value>& options);

/// "Pairwise(threshold=0.1, min_particles=64)", "PrefixCuts()", "Static": options that are left out have their
/// defaults. Throws std::invalid_argument for an unknown name or option, which includes balancers that a script defines
/// itself.
std::shared_ptr<Policy> policy_named(const std::string& call);

}  // namespace motes::balance
