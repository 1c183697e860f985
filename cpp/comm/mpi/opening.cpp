// Which MPI library this process has, and of which ABI it is. The library is never linked: its functions are looked up
// in what is already loaded, so no second MPI gets into the process.
#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "comm/environment.h"
#include "comm/mpi/functions.h"
#include "comm/mpi/library.h"

namespace motes::comm {
namespace {

const MpiLibrary& library_in(void* loaded) {
  if (auto* const abi = find_in<int (*)(int*, int*)>(loaded, "MPI_Abi_get_version"); abi != nullptr) {
    int major = 0;
    int minor = 0;
    if (abi(&major, &minor) == 0 && major > 0) return standard::library(loaded);
  }
  return dlsym(loaded, "ompi_mpi_comm_world") != nullptr ? openmpi::library(loaded) : mpich::library(loaded);
}

// Returns whether MPICH's launcher started this process, or one that speaks only its language.
bool started_by_mpich() {
  return std::getenv("PMIX_RANK") == nullptr &&
         (std::getenv("PMI_RANK") != nullptr || std::getenv("PMI_SIZE") != nullptr);
}

// Returns the folder of libraries beside that of the program that started this one: a launcher's are there.
std::string launchers_folder() {
  std::array<char, 4096> path{};
  const std::string link = "/proc/" + std::to_string(getppid()) + "/exe";
  const ssize_t length = readlink(link.c_str(), path.data(), path.size());
  return std::string(path.data(), length > 0 ? static_cast<std::size_t>(length) : 0) + "/../../lib/";
}

// Returns where the MPI library of a program may be: files, and names for the dynamic linker.
std::vector<std::string> places() {
  std::vector<std::string> all;
  if (const char* const chosen = std::getenv("MPI4PY_LIBMPI"); chosen != nullptr && *chosen != '\0') {
    std::istringstream list(chosen);
    for (std::string place; std::getline(list, place, ':');) all.push_back(place);
    return all;
  }
  std::vector<std::string> names{"libmpi.so.40", "libmpi.so.12", "libmpich.so.12", "libmpi_abi.so.1"};
  if (started_by_mpich()) std::rotate(names.begin(), names.begin() + 1, names.end());
  for (const std::string& name : names) {
    all.push_back(std::filesystem::path(launchers_folder() + name).lexically_normal());
  }
  all.insert(all.end(), names.begin(), names.end());
  return all;
}

}  // namespace

std::string use_mpi(const std::string& module, std::optional<int> world) {
  void* const loaded = dlopen(module.c_str(), RTLD_LAZY | RTLD_NOLOAD);
  if (loaded == nullptr) throw CommError(module + " is not loaded in this process");
  const MpiLibrary& library = library_in(loaded);
  if (world && library.world() != *world) {
    throw CommError(library.version() + " has neither the ABI of Open MPI, nor that of MPICH, nor that of MPI 5");
  }
  use(library);
  return library.abi();
}

const MpiLibrary& program_library() {
  if (dlsym(RTLD_DEFAULT, "MPI_Init") != nullptr) return library_in(dlopen(nullptr, RTLD_LAZY));
  std::string why;
  for (const std::string& place : places()) {
    if (void* const loaded = dlopen(place.c_str(), RTLD_LAZY | RTLD_LOCAL); loaded != nullptr)
      return library_in(loaded);
    why = dlerror();
  }
  throw CommError("no MPI library can be loaded (" + why + "): name one in the variable MPI4PY_LIBMPI");
}

}  // namespace motes::comm
