// The ABI of the MPI 5 standard, libmpi_abi.so: handles are pointers, and predefined ones are small numbers.
#pragma once

#include <cstdint>

#include "comm/mpi/functions.h"

namespace motes::comm::standard {

inline constexpr char kAbi[] = "MPI 5";

using MPI_Comm = struct OpaqueComm*;
using MPI_Datatype = struct OpaqueDatatype*;
using MPI_Errhandler = struct OpaqueErrhandler*;
using MPI_Group = struct OpaqueGroup*;
using MPI_Message = struct OpaqueMessage*;
using MPI_Op = struct OpaqueOp*;
using MPI_Request = struct OpaqueRequest*;
using MPI_Status = MpiStatus;

template <class Handle>
Handle predefined(std::uintptr_t number) {
  return reinterpret_cast<Handle>(number);  // NOLINT(performance-no-int-to-ptr): so the standard defines them
}

inline const auto MPI_COMM_NULL = predefined<MPI_Comm>(0x100);
inline const auto MPI_COMM_WORLD = predefined<MPI_Comm>(0x101);
inline const auto MPI_BYTE = predefined<MPI_Datatype>(0x247);
inline const auto MPI_CHAR = predefined<MPI_Datatype>(0x243);
inline const auto MPI_INT = predefined<MPI_Datatype>(0x209);
inline const auto MPI_ERRORS_RETURN = predefined<MPI_Errhandler>(0x143);
inline const auto MPI_GROUP_NULL = predefined<MPI_Group>(0x108);
inline const auto MPI_MESSAGE_NULL = predefined<MPI_Message>(0x128);
inline const auto MPI_MIN = predefined<MPI_Op>(0x22);
inline const auto MPI_REQUEST_NULL = predefined<MPI_Request>(0x180);
inline constexpr int MPI_SUCCESS = 0;
inline constexpr MPI_Status* MPI_STATUS_IGNORE = nullptr;

MOTES_MPI_FUNCTIONS(MOTES_MPI_POINTER)
inline MPI_Comm (*MPI_Comm_f2c)(int) = nullptr;
inline int (*MPI_Comm_c2f)(MPI_Comm) = nullptr;

inline void find_all(void* library) {
#define MOTES_FIND(name, parameters) find_needed(library, #name, name);
  MOTES_MPI_FUNCTIONS(MOTES_FIND)
#undef MOTES_FIND
  find_needed(library, "MPI_Comm_fromint", MPI_Comm_f2c);
  find_needed(library, "MPI_Comm_toint", MPI_Comm_c2f);
}

}  // namespace motes::comm::standard
