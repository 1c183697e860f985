// MPI for programs of their own; under Python mpi4py starts and ends it.
#pragma once

#include <string>
#include <vector>

namespace motes::comm {

/// Name and version of the MPI library in use.
std::string library_version();

/// Lets this process, which a rank has forked off, count MPI as ended: at its exit nothing may call MPI_Finalize, which
/// would talk to the other ranks in its parent's name. False where the MPI offers no way.
bool forget_mpi();

/// MPI from its start to its end: one per program.
class Environment {
 public:
  /// Starts MPI. Throws CommError where it cannot.
  Environment(int& argc, char**& argv);
  /// Collective. Ends MPI: waits for the other ranks.
  ~Environment();
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

  /// What make_mpi() takes: all ranks that the launcher started.
  int world() const;
  int rank() const { return rank_; }
  int size() const { return size_; }

  /// Collective. The host of each rank, on rank `at`; empty elsewhere: thousands of names are many bytes.
  std::vector<std::string> hosts(int at) const;

  /// Collective. The lowest rank that says true, or -1.
  int first(bool here) const;

  /// Ends the job on all ranks, with this exit code.
  [[noreturn]] void abort(int code) const;

 private:
  int rank_ = 0;
  int size_ = 1;
};

}  // namespace motes::comm
