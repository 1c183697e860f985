// Ranks that are MPI processes or SimGrid's simulated ranks, depending on which of the two motes_mpi was built for.
#pragma once

#include <memory>

#include "comm/transport.h"

namespace motes::comm {

/// Makes a transport over a duplicate of the user's communicator, with its own error handler. `handle`: MPI_Comm_c2f of
/// the user's communicator; MPI must be initialised. Throws CommError if there is no such communicator.
std::unique_ptr<Transport> make_mpi(int handle);

/// Returns whether this was built for an MPI that can survive the loss of a rank, if its launcher enables that.
bool mpi_can_survive();

}  // namespace motes::comm
