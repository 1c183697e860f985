// Signals that ask a run to stop: they are noted at once, whatever this process is doing, and a run ends at the border
// of its frame.
#pragma once

#include <vector>

namespace motes::comm {

/// From now on these signals of SIGINT, SIGTERM and SIGUSR1 are noted instead of ending the process. A second SIGINT or
/// SIGTERM does what it did before this call; so does every signal in a child process that was forked.
/// `same_s`: seconds within which a signal that comes again counts as the same one, since launchers and schedulers may
/// both pass it on. `speaks`: the first signal says on standard error what will happen. Calling it again installs what
/// somebody else has replaced meanwhile.
void note_stop_signals(const std::vector<int>& signals, double same_s, bool speaks);

/// The first signal that was noted, or 0.
int stop_signal();

/// The next signal is the first one.
void forget_stop_signal();

/// The signals do what they did before, unless somebody else has taken them over meanwhile.
void release_stop_signals();

/// This process will end with this exit code where it would end with 0.
void end_with_code(int code);

}  // namespace motes::comm
