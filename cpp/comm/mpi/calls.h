// MPI's C interface, for the files that call it. They are compiled once per ABI: the build names its namespace,
// MOTES_MPI_ABI, and the header with its types and functions, MOTES_MPI_HEADER.
#pragma once

#include MOTES_MPI_HEADER

#include <memory>
#include <string>

#include "comm/errors.h"
#include "comm/message.h"
#include "comm/transport.h"

namespace motes::comm::MOTES_MPI_ABI {

inline constexpr std::size_t kText = 8192;  // the longest text of any MPI

/// Turns an error code into a CommError.
inline void check(int code, const char* what) {
  if (code == MPI_SUCCESS) return;
  char text[kText] = "";
  int length = 0;
  MPI_Error_string(code, text, &length);
  throw CommError(std::string(what) + ": " + std::string(text, static_cast<std::size_t>(length)));
}

inline int tag(Phase phase) { return 100 + static_cast<int>(phase); }

/// MPI counts bytes in an int: larger messages travel in pieces, which MPI keeps in order.
inline constexpr std::size_t kPiece = std::size_t{1} << 30;

/// Makes a transport over a duplicate of the user's communicator.
std::unique_ptr<Transport> connect(MPI_Comm users);

/// Makes this thread use the simulator's time, if MPI is simulated.
void keep_mpi_time();

}  // namespace motes::comm::MOTES_MPI_ABI
