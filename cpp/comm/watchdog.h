// An end that cannot hang: for a process that is being given up while MPI or Python may be stuck.
#pragma once

namespace motes::comm {

/// Ends this process with this exit code after so many seconds, from a thread of its own: whatever locks others hold
/// and whatever signals the script handles or blocks. Of several calls the earliest end counts.
void end_process_after(double seconds, int code);

}  // namespace motes::comm
