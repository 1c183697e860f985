// A balancer in another program, which answers over two named pipes: that of a script, where the engine runs without
// Python.
#pragma once

#include <string>

#include "balance/policy.h"

namespace motes::driver {

/// Opens the balancer that a directory describes (python/motes/cluster/deciding.py writes it). Its file `facts` has the
/// name, the smoothing, and "system" or "all" in three lines. Into the pipe `tables` go lines
///
///   frame evaluation axes N  N x (particles seconds speed error)  (N - 1) x cut  system
///
/// and out of the pipe `plans` come "shares" and N numbers, "orders" and any number of "from to count", or "error" and
/// its text. Only the manager opens the pipes. Throws std::runtime_error where the file cannot be read; planning
/// throws it where nobody answers.
balance::PolicyPtr asked(const std::string& directory);

}  // namespace motes::driver
