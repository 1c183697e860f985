// The other side of abi_values.cpp: the library's own header, and whether our functions have its types.
#include REAL_HEADER

#include <cstdint>
#include <map>
#include <string>
#include <type_traits>

#if defined(OPEN_MPI)
#include <mpi-ext.h>
#endif

#include "comm/mpi/functions.h"

#define SAME(name, parameters) static_assert(std::is_same_v<decltype(&name), int(*) parameters>, #name);
MOTES_MPI_FUNCTIONS(SAME)

std::map<std::string, std::uintptr_t> real_values() {
  std::map<std::string, std::uintptr_t> values;
#define VALUE(name) values[#name] = (std::uintptr_t)(name);
#include "abi_names.inc"
  return values;
}

std::size_t real_status_bytes() { return sizeof(MPI_Status); }
