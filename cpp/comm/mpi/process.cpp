#include "comm/environment.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "comm/clock.h"
#include "comm/mpi_calls.h"

#ifdef OPEN_MPI
// Open MPI's record of its own state, from its first call to the end of MPI_Finalize.
extern "C" __attribute__((weak)) std::int32_t ompi_mpi_state;
#endif

namespace motes::comm {
namespace {

constexpr std::size_t kName = 256;

}  // namespace

Environment::Environment(int& argc, char**& argv) {
  if (MPI_Init(&argc, &argv) != MPI_SUCCESS) throw CommError("MPI_Init failed");
  keep_mpi_time();
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
}

Environment::~Environment() { MPI_Finalize(); }

int Environment::world() const { return MPI_Comm_c2f(MPI_COMM_WORLD); }

std::vector<std::string> Environment::hosts(int at) const {
  static_assert(kName >= MPI_MAX_PROCESSOR_NAME);
  std::array<char, kName> own{};
  int length = 0;
  MPI_Get_processor_name(own.data(), &length);
  std::vector<char> all(rank_ == at ? kName * static_cast<std::size_t>(size_) : 0);
  MPI_Gather(own.data(), kName, MPI_CHAR, all.data(), kName, MPI_CHAR, at, MPI_COMM_WORLD);
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin < all.size(); begin += kName) names.emplace_back(all.data() + begin);
  return names;
}

int Environment::first(bool here) const {
  int own = here ? rank_ : size_;
  int lowest = 0;
  MPI_Allreduce(&own, &lowest, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  return lowest == size_ ? -1 : lowest;
}

void Environment::abort(int code) const {
  std::fflush(nullptr);
  // A simulator's ranks are threads of one process, whose exit code MPI_Abort would leave at 0.
  if (!simulated()) MPI_Abort(MPI_COMM_WORLD, code);
  std::_Exit(code);
}

bool forget_mpi() {
#ifdef OPEN_MPI
  constexpr std::int32_t kFinalized = 5;  // OMPI_MPI_STATE_FINALIZE_COMPLETED, since Open MPI 3
  if (&ompi_mpi_state == nullptr) return false;
  ompi_mpi_state = kFinalized;
  int ended = 0;
  return MPI_Finalized(&ended) == MPI_SUCCESS && ended != 0;
#else
  return false;
#endif
}

std::string library_version() {
  char text[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  int length = 0;
  MPI_Get_library_version(text, &length);
  const std::string whole(text, static_cast<std::size_t>(length));
  return whole.substr(0, whole.find(','));
}

}  // namespace motes::comm
