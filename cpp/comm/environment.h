// MPI for standalone programs; under Python, mpi4py starts and ends it.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace motes::comm {

/// Makes the engine use the MPI library that a loaded module of this process is linked to. `module`: its path; `world`:
/// MPI_Comm_c2f(MPI_COMM_WORLD) as the module knows it, once MPI has started. Returns the name of the library's ABI.
/// Throws CommError if it is unknown.
std::string use_mpi(const std::string& module, std::optional<int> world);

/// Returns the name and version of the MPI library in use.
std::string library_version();

/// Marks MPI as finalized in this process, which a rank has forked: calling MPI_Finalize at its exit would talk to the
/// other ranks in its parent's name. Returns false if the MPI library offers no way.
bool forget_mpi();

/// MPI from its start to its end: one per program.
class Environment {
 public:
  /// Starts MPI: the library that the program is linked to, that MPI4PY_LIBMPI names, or that the dynamic linker finds.
  /// Throws CommError if it cannot.
  Environment(int& argc, char**& argv);
  /// Collective. Ends MPI: waits for the other ranks.
  ~Environment();
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

  /// Returns the handle of all ranks that the launcher started, for make_mpi().
  int world() const;
  int rank() const { return rank_; }
  int size() const { return size_; }

  /// Collective. Returns the host of each rank on rank `at`; empty elsewhere, since thousands of names are many bytes.
  std::vector<std::string> hosts(int at) const;

  /// Collective. Returns the lowest rank that passes true, or -1.
  int first(bool here) const;

  /// Ends the job on all ranks, with this exit code.
  [[noreturn]] void abort(int code) const;

 private:
  int rank_ = 0;
  int size_ = 1;
};

}  // namespace motes::comm
