// The MPI library of this process: the rest of the engine sees no more of MPI than this.
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "comm/clock.h"
#include "comm/environment.h"
#include "comm/mpi/library.h"
#include "comm/mpi_transport.h"

namespace motes::comm {
namespace {

const MpiLibrary* in_use = nullptr;

const MpiLibrary& used() {
  if (in_use == nullptr) throw CommError("MPI is not loaded in this process");
  return *in_use;
}

}  // namespace

void use(const MpiLibrary& library) { in_use = &library; }

std::unique_ptr<Transport> make_mpi(int handle) { return used().connect(handle); }

bool mpi_can_survive() { return in_use != nullptr && in_use->can_survive(); }

bool forget_mpi() { return in_use != nullptr && in_use->forget(); }

std::string library_version() { return used().version(); }

Environment::Environment(int& argc, char**& argv) {
  use(program_library());
  used().start(argc, argv);
  rank_ = used().rank();
  size_ = used().size();
}

Environment::~Environment() { in_use->end(); }

int Environment::world() const { return used().world(); }

std::vector<std::string> Environment::hosts(int at) const { return used().hosts(at); }

int Environment::first(bool here) const {
  const int lowest = used().lowest(here ? rank_ : size_);
  return lowest == size_ ? -1 : lowest;
}

void Environment::abort(int code) const {
  std::fflush(nullptr);
  // A simulator's ranks are threads of one process, whose exit code MPI_Abort would leave at 0.
  if (!simulated()) used().abort(code);
  std::_Exit(code);
}

}  // namespace motes::comm
