// The ABI that MPICH, Intel MPI, Cray MPICH and MVAPICH share since 2014, libmpi.so.12: handles are numbers.
#pragma once

#include "comm/mpi/functions.h"

namespace motes::comm::mpich {

inline constexpr char kAbi[] = "MPICH";

using MPI_Comm = int;
using MPI_Datatype = int;
using MPI_Errhandler = int;
using MPI_Group = int;
using MPI_Message = int;
using MPI_Op = int;
using MPI_Request = int;
using MPI_Status = MpiStatus;

inline constexpr MPI_Comm MPI_COMM_NULL = 0x04000000;
inline constexpr MPI_Comm MPI_COMM_WORLD = 0x44000000;
inline constexpr MPI_Datatype MPI_BYTE = 0x4c00010d;
inline constexpr MPI_Datatype MPI_CHAR = 0x4c000101;
inline constexpr MPI_Datatype MPI_INT = 0x4c000405;
inline constexpr MPI_Errhandler MPI_ERRORS_RETURN = 0x54000001;
inline constexpr MPI_Group MPI_GROUP_NULL = 0x08000000;
inline constexpr MPI_Message MPI_MESSAGE_NULL = 0x2c000000;
inline constexpr MPI_Op MPI_MIN = 0x58000002;
inline constexpr MPI_Request MPI_REQUEST_NULL = 0x2c000000;
inline constexpr int MPI_SUCCESS = 0;
inline MPI_Status* const MPI_STATUS_IGNORE = reinterpret_cast<MPI_Status*>(1);

MOTES_MPI_FUNCTIONS(MOTES_MPI_POINTER)
inline MPI_Comm MPI_Comm_f2c(int handle) { return handle; }
inline int MPI_Comm_c2f(MPI_Comm comm) { return comm; }

inline void find_all(void* library) {
#define MOTES_FIND(name, parameters) find_needed(library, #name, name);
  MOTES_MPI_FUNCTIONS(MOTES_FIND)
#undef MOTES_FIND
}

}  // namespace motes::comm::mpich
