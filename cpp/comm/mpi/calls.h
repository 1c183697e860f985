// MPI's C interface, for the files that call it.
#pragma once

#define OMPI_SKIP_MPICXX
#define MPICH_SKIP_MPICXX
#include <mpi.h>

#include <string>

#include "comm/errors.h"
#include "comm/message.h"

namespace motes::comm {

/// Turns an error code into a CommError.
inline void check(int code, const char* what) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(code, text, &length);
  throw CommError(std::string(what) + ": " + std::string(text, static_cast<std::size_t>(length)));
}

inline MPI_Comm live(int handle) {
  const MPI_Comm comm = MPI_Comm_f2c(handle);
  if (comm == MPI_COMM_NULL) throw CommError("comm must be a live communicator");
  return comm;
}

inline int tag(Phase phase) { return 100 + static_cast<int>(phase); }

/// MPI counts bytes in an int: larger messages travel in pieces, which MPI keeps in order.
inline constexpr std::size_t kPiece = std::size_t{1} << 30;

/// Makes this thread use the simulator's time, if MPI is simulated.
void keep_mpi_time();

}  // namespace motes::comm
