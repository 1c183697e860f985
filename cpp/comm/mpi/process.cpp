// What the engine asks of MPI but for its messages: the process, its start and its end.
#include <array>
#include <cstdint>

#include "comm/mpi/calls.h"
#include "comm/mpi/library.h"
#include "comm/mpi/losses.h"

namespace motes::comm::MOTES_MPI_ABI {
namespace {

constexpr std::size_t kName = 256;

class Library : public MpiLibrary {
 public:
  explicit Library(void* loaded) : loaded_(loaded) {}

  std::unique_ptr<Transport> connect(int handle) const override {
    const MPI_Comm users = MPI_Comm_f2c(handle);
    if (users == MPI_COMM_NULL) throw CommError("comm must be a live communicator");
    return MOTES_MPI_ABI::connect(users);
  }

  bool can_survive() const override { return losses::can_be_survived(); }

#ifdef MOTES_MPI_LINKED
  std::string abi() const override { return ""; }
  bool forget() const override { return false; }
#else
  std::string abi() const override { return kAbi; }

  bool forget() const override {
    // Open MPI's record of its own state, from its first call to the end of MPI_Finalize.
    auto* const state = find_in<std::int32_t*>(loaded_, "ompi_mpi_state");
    constexpr std::int32_t kFinalized = 5;  // OMPI_MPI_STATE_FINALIZE_COMPLETED, since Open MPI 3
    if (state == nullptr) return false;
    *state = kFinalized;
    int ended = 0;
    return MPI_Finalized(&ended) == MPI_SUCCESS && ended != 0;
  }
#endif

  std::string version() const override {
    std::array<char, kText> text{};
    int length = 0;
    MPI_Get_library_version(text.data(), &length);
    const std::string whole(text.data(), static_cast<std::size_t>(length));
    return whole.substr(0, whole.find(','));
  }

  void start(int& argc, char**& argv) const override {
    if (MPI_Init(&argc, &argv) != MPI_SUCCESS) throw CommError("MPI_Init failed");
    keep_mpi_time();
  }

  void end() const override { MPI_Finalize(); }

  int world() const override { return MPI_Comm_c2f(MPI_COMM_WORLD); }

  int rank() const override {
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    return rank;
  }

  int size() const override {
    int size = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    return size;
  }

  std::vector<std::string> hosts(int at) const override {
    std::array<char, kText> own{};
    int length = 0;
    MPI_Get_processor_name(own.data(), &length);
    own[kName - 1] = '\0';
    std::vector<char> all(rank() == at ? kName * static_cast<std::size_t>(size()) : 0);
    MPI_Gather(own.data(), kName, MPI_CHAR, all.data(), kName, MPI_CHAR, at, MPI_COMM_WORLD);
    std::vector<std::string> names;
    for (std::size_t begin = 0; begin < all.size(); begin += kName) names.emplace_back(all.data() + begin);
    return names;
  }

  int lowest(int number) const override {
    int lowest = 0;
    MPI_Allreduce(&number, &lowest, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    return lowest;
  }

  void abort(int code) const override { MPI_Abort(MPI_COMM_WORLD, code); }

 private:
  [[maybe_unused]] void* loaded_;
};

}  // namespace

const MpiLibrary& library(void* loaded) {
#ifndef MOTES_MPI_LINKED
  find_all(loaded);
#endif
  static const Library library(loaded);
  return library;
}

}  // namespace motes::comm::MOTES_MPI_ABI
