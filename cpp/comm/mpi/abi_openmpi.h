// Open MPI's ABI, libmpi.so.40: handles are pointers, and predefined ones point to variables of the library.
#pragma once

#include "comm/mpi/functions.h"

namespace motes::comm::openmpi {

inline constexpr char kAbi[] = "Open MPI";

using MPI_Comm = struct OpaqueComm*;
using MPI_Datatype = struct OpaqueDatatype*;
using MPI_Errhandler = struct OpaqueErrhandler*;
using MPI_Group = struct OpaqueGroup*;
using MPI_Message = struct OpaqueMessage*;
using MPI_Op = struct OpaqueOp*;
using MPI_Request = struct OpaqueRequest*;
using MPI_Status = MpiStatus;

// X(type, name, variable of the library)
#define MOTES_MPI_VALUES(X)                                    \
  X(MPI_Comm, MPI_COMM_NULL, ompi_mpi_comm_null)               \
  X(MPI_Comm, MPI_COMM_WORLD, ompi_mpi_comm_world)             \
  X(MPI_Datatype, MPI_BYTE, ompi_mpi_byte)                     \
  X(MPI_Datatype, MPI_CHAR, ompi_mpi_char)                     \
  X(MPI_Datatype, MPI_INT, ompi_mpi_int)                       \
  X(MPI_Errhandler, MPI_ERRORS_RETURN, ompi_mpi_errors_return) \
  X(MPI_Group, MPI_GROUP_NULL, ompi_mpi_group_null)            \
  X(MPI_Message, MPI_MESSAGE_NULL, ompi_message_null)          \
  X(MPI_Op, MPI_MIN, ompi_mpi_op_min)                          \
  X(MPI_Request, MPI_REQUEST_NULL, ompi_request_null)

#define MOTES_VALUE(type, name, variable) inline type name = nullptr;
MOTES_MPI_VALUES(MOTES_VALUE)
#undef MOTES_VALUE
inline constexpr int MPI_SUCCESS = 0;
inline constexpr MPI_Status* MPI_STATUS_IGNORE = nullptr;

MOTES_MPI_FUNCTIONS(MOTES_MPI_POINTER)
inline MPI_Comm (*MPI_Comm_f2c)(int) = nullptr;
inline int (*MPI_Comm_c2f)(MPI_Comm) = nullptr;

// ULFM, which versions before 5, and builds without it, do not have.
#define MOTES_MPI_ULFM
#define MOTES_MPI_ULFM_FUNCTIONS(X)                   \
  X(MPIX_Comm_agree, (MPI_Comm, int*))                \
  X(MPIX_Comm_get_failed, (MPI_Comm, MPI_Group*))     \
  X(MPIX_Comm_iagree, (MPI_Comm, int*, MPI_Request*)) \
  X(MPIX_Comm_is_revoked, (MPI_Comm, int*))           \
  X(MPIX_Comm_revoke, (MPI_Comm))                     \
  X(MPIX_Comm_shrink, (MPI_Comm, MPI_Comm*))
MOTES_MPI_ULFM_FUNCTIONS(MOTES_MPI_POINTER)
inline constexpr int MPIX_FT = 12;
inline constexpr int MPIX_ERR_PROC_FAILED = 75;
inline constexpr int MPIX_ERR_PROC_FAILED_PENDING = 76;
inline constexpr int MPIX_ERR_REVOKED = 77;

inline void find_all(void* library) {
#define MOTES_FIND(name, parameters) find_needed(library, #name, name);
  MOTES_MPI_FUNCTIONS(MOTES_FIND)
#undef MOTES_FIND
  find_needed(library, "MPI_Comm_f2c", MPI_Comm_f2c);
  find_needed(library, "MPI_Comm_c2f", MPI_Comm_c2f);
#define MOTES_FIND(name, parameters) name = find_in<decltype(name)>(library, #name);
  MOTES_MPI_ULFM_FUNCTIONS(MOTES_FIND)
#undef MOTES_FIND
#define MOTES_FIND(type, name, variable) find_needed(library, #variable, name);
  MOTES_MPI_VALUES(MOTES_FIND)
#undef MOTES_FIND
}

}  // namespace motes::comm::openmpi
