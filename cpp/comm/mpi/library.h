// What the engine asks of an MPI library. It is written once, and compiled for each ABI (abi_*.h) in a namespace of its
// own; which one is used is decided by the library that the process has loaded.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "comm/transport.h"

namespace motes::comm {

class MpiLibrary {
 public:
  MpiLibrary() = default;
  virtual ~MpiLibrary() = default;
  MpiLibrary(const MpiLibrary&) = delete;
  MpiLibrary& operator=(const MpiLibrary&) = delete;

  virtual std::unique_ptr<Transport> connect(int handle) const = 0;
  virtual bool can_survive() const = 0;
  virtual bool forget() const = 0;
  virtual std::string version() const = 0;
  virtual std::string abi() const = 0;

  // For programs; see Environment.
  virtual void start(int& argc, char**& argv) const = 0;
  virtual void end() const = 0;
  virtual int world() const = 0;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  virtual std::vector<std::string> hosts(int at) const = 0;
  virtual int lowest(int number) const = 0;  // of the numbers of all ranks
  virtual void abort(int code) const = 0;
};

// Each takes what dlopen returned for the library or for what is linked to it.
namespace openmpi {
const MpiLibrary& library(void* loaded);
}
namespace mpich {
const MpiLibrary& library(void* loaded);
}
namespace standard {
const MpiLibrary& library(void* loaded);
}
namespace smpi {
const MpiLibrary& library(void* loaded);  // linked: needs nothing
}

/// Makes the engine use a library from now on.
void use(const MpiLibrary& library);

/// Returns the MPI library of a program, which it loads. Throws CommError if there is none.
const MpiLibrary& program_library();

}  // namespace motes::comm
