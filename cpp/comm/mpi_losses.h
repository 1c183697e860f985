// Lost processes, as far as MPI lets the others go on without them: Open MPI's extension ULFM. Without it, nothing is
// survived, and nothing else here may be called.
#pragma once

#include "comm/mpi_calls.h"

namespace motes::comm::losses {

/// Whether this was built for such a library.
bool can_be_survived();

/// Whether this job goes on without a process that is gone: the library can, and the launcher was told so.
bool survived();

/// Whether an error code says that a process is gone, or that a communicator was revoked.
bool is_loss(int code);

/// A rank of the communicator that is known to be gone; -1: none.
int lost_rank(MPI_Comm comm);

void revoke(MPI_Comm comm);
bool revoked(MPI_Comm comm);

/// Starts an agreement of all ranks that live, also on a revoked communicator: then `flag` has the bits that all of
/// them had set. Both must stay where they are until the request is done.
void agree(MPI_Comm comm, int* flag, MPI_Request* request);

/// A communicator of the ranks that live, the same on all of them. Waits until they have come.
MPI_Comm shrunk(MPI_Comm comm);

}  // namespace motes::comm::losses
