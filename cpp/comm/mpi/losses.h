// Continues after the loss of processes, with Open MPI's extension ULFM. If survived() is false, none of the functions
// below it may be called.
#pragma once

#include "comm/mpi/calls.h"

namespace motes::comm::MOTES_MPI_ABI::losses {

/// Returns whether the MPI library has ULFM.
bool can_be_survived();

/// Returns whether this job continues after the loss of a process: the library supports it and the launcher enabled it.
bool survived();

/// Returns whether an error code means that a process is gone or that a communicator was revoked.
bool is_loss(int code);

/// Returns a rank of the communicator that is known to be lost; -1: none.
int lost_rank(MPI_Comm comm);

void revoke(MPI_Comm comm);
bool revoked(MPI_Comm comm);

/// Starts an agreement among the surviving ranks, even on a revoked communicator. When the request is done, `flag` has
/// the bits that all of them had set. Both must stay in place until then.
void agree(MPI_Comm comm, int* flag, MPI_Request* request);

/// Returns a communicator of the surviving ranks, the same on all of them. Waits until all have called this.
MPI_Comm shrunk(MPI_Comm comm);

}  // namespace motes::comm::MOTES_MPI_ABI::losses
