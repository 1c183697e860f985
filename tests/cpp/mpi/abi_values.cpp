// Compares an ABI of ours (cpp/comm/mpi) with the library's own header, in a process that has loaded the library.
// Argument: the library. The two headers cannot be included together: abi_real.cpp has the other side.
#include <dlfcn.h>

#include <cstdint>
#include <cstdio>
#include <map>
#include <string>

#include MOTES_MPI_HEADER

std::map<std::string, std::uintptr_t> real_values();
std::size_t real_status_bytes();

using namespace motes::comm::MOTES_MPI_ABI;

int main(int, char** argv) {
  void* const library = dlopen(argv[1], RTLD_LAZY);
  if (library == nullptr) return std::puts(dlerror());
  find_all(library);
  std::map<std::string, std::uintptr_t> ours;
#define VALUE(name) ours[#name] = (std::uintptr_t)(name);
#include "abi_names.inc"
  int different = 0;
  for (const auto& [name, value] : real_values()) {
    if (ours.count(name) != 0 && ours[name] == value) continue;
    std::printf("%s: %#zx is %#zx\n", name.c_str(), std::size_t(ours[name]), std::size_t(value));
    ++different;
  }
  if (real_status_bytes() > sizeof(MPI_Status)) different += std::printf("MPI_Status is too small\n");
  if (different == 0) std::puts("all equal");
  return different == 0 ? 0 : 1;
}
