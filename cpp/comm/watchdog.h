// Ends a process without fail, even if MPI or Python are stuck.
#pragma once

namespace motes::comm {

/// Ends this process with this exit code after `seconds`, from a separate thread: whatever locks others hold and
/// whatever signals the script handles or blocks. Of several calls, the earliest end counts.
void end_process_after(double seconds, int code);

}  // namespace motes::comm
