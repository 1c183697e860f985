// Ranks that are MPI processes, or SimGrid's simulated ones: which of the two the library motes_mpi was built for.
#pragma once

#include <memory>

#include "comm/transport.h"

namespace motes::comm {

/// A duplicate of the user's communicator with an error handler of its own. `handle`: MPI_Comm_c2f of the user's, of
/// which MPI_Init has been called. Throws CommError where there is no such communicator.
std::unique_ptr<Transport> make_mpi(int handle);

/// Whether this was built for an MPI whose connections can survive the loss of a rank, if its launcher says so.
bool mpi_can_survive();

}  // namespace motes::comm
