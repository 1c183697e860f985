// A balancer in another program, which is asked over two named pipes: for the balancers of scripts, when the engine
// runs without Python.
#pragma once

#include <string>

#include "balance/policy.h"

namespace motes::driver {

/// Opens the balancer that a directory describes (python/motes_lab/cluster/deciding.py writes it). Its file `facts`
/// holds the name, the smoothing, and "system" or "all" in three lines. Each request is a line in the pipe `tables`:
///
///   frame evaluation axes N  N x (particles seconds speed error)  (N - 1) x cut  system
///
/// Each answer is a line in the pipe `plans`: "shares" and N numbers, "orders" and any number of "from to count", or
/// "error" and its text. Only the manager opens the pipes. Throws std::runtime_error if the file cannot be read;
/// planning throws it if nobody answers.
balance::PolicyPtr open_piped_policy(const std::string& directory);

}  // namespace motes::driver
