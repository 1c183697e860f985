// Signals that stop a run: they are noted at once, whatever this process is doing, and the run ends after its current
// frame.
#pragma once

#include <vector>

namespace motes::comm {

/// Notes the given signals, of SIGINT, SIGTERM and SIGUSR1, instead of letting them end the process. A second SIGINT or
/// SIGTERM has the effect that it had before this call; so does every signal in a forked child process. `same_s`:
/// seconds within which a repeated signal counts as the same one, since launchers and schedulers may both forward it.
/// `speaks`: the first signal prints on standard error what will happen. Another call reinstalls handlers that others
/// have replaced.
void note_stop_signals(const std::vector<int>& signals, double same_s, bool speaks);

/// Returns the first signal that was noted, or 0.
int stop_signal();

/// Forgets the noted signals: the next one counts as the first.
void forget_stop_signal();

/// Restores the previous handlers of the signals, unless others have replaced ours meanwhile.
void release_stop_signals();

/// Makes this process end with this exit code where it would end with 0.
void end_with_code(int code);

}  // namespace motes::comm
