// The functions of MPI that the engine calls, as pointers that are found in a library while the program runs: nothing
// is linked to MPI. Included by each ABI after its types.
#pragma once

#include <dlfcn.h>

#include <string>

#include "comm/errors.h"

// X(name, parameters): all of them return an int.
#define MOTES_MPI_FUNCTIONS(X)                                                             \
  X(MPI_Abort, (MPI_Comm, int))                                                            \
  X(MPI_Allreduce, (const void*, void*, int, MPI_Datatype, MPI_Op, MPI_Comm))              \
  X(MPI_Comm_free, (MPI_Comm*))                                                            \
  X(MPI_Comm_get_attr, (MPI_Comm, int, void*, int*))                                       \
  X(MPI_Comm_group, (MPI_Comm, MPI_Group*))                                                \
  X(MPI_Comm_idup, (MPI_Comm, MPI_Comm*, MPI_Request*))                                    \
  X(MPI_Comm_rank, (MPI_Comm, int*))                                                       \
  X(MPI_Comm_set_errhandler, (MPI_Comm, MPI_Errhandler))                                   \
  X(MPI_Comm_size, (MPI_Comm, int*))                                                       \
  X(MPI_Error_class, (int, int*))                                                          \
  X(MPI_Error_string, (int, char*, int*))                                                  \
  X(MPI_Finalize, ())                                                                      \
  X(MPI_Finalized, (int*))                                                                 \
  X(MPI_Gather, (const void*, int, MPI_Datatype, void*, int, MPI_Datatype, int, MPI_Comm)) \
  X(MPI_Get_count, (const MPI_Status*, MPI_Datatype, int*))                                \
  X(MPI_Get_library_version, (char*, int*))                                                \
  X(MPI_Get_processor_name, (char*, int*))                                                 \
  X(MPI_Group_free, (MPI_Group*))                                                          \
  X(MPI_Group_size, (MPI_Group, int*))                                                     \
  X(MPI_Group_translate_ranks, (MPI_Group, int, const int*, MPI_Group, int*))              \
  X(MPI_Ibarrier, (MPI_Comm, MPI_Request*))                                                \
  X(MPI_Improbe, (int, int, MPI_Comm, int*, MPI_Message*, MPI_Status*))                    \
  X(MPI_Imrecv, (void*, int, MPI_Datatype, MPI_Message*, MPI_Request*))                    \
  X(MPI_Init, (int*, char***))                                                             \
  X(MPI_Isend, (const void*, int, MPI_Datatype, int, int, MPI_Comm, MPI_Request*))         \
  X(MPI_Test, (MPI_Request*, int*, MPI_Status*))

// Defines a function that is found in the library.
// NOLINTNEXTLINE(bugprone-macro-parentheses): a name and its parameters
#define MOTES_MPI_POINTER(name, parameters) inline int(*name) parameters = nullptr;

namespace motes::comm {

/// Large enough in each ABI. Nothing reads it but MPI.
struct MpiStatus {
  alignas(8) unsigned char bytes[64];
};

/// Finds a function or a value of an MPI library, which may be null. `library`: from dlopen.
template <class Pointer>
Pointer find_in(void* library, const char* name) {
  return reinterpret_cast<Pointer>(dlsym(library, name));
}

/// The same. Throws CommError if the library has none.
template <class Pointer>
void find_needed(void* library, const char* name, Pointer& found) {
  found = find_in<Pointer>(library, name);
  if (found == nullptr) throw CommError(std::string("the MPI library has no ") + name + ": MPI 3 is needed");
}

}  // namespace motes::comm
