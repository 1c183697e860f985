#include "comm/clock.h"

#define OMPI_SKIP_MPICXX
#define MPICH_SKIP_MPICXX
#include <mpi.h>
#include <time.h>
#ifdef MOTES_SMPI
#include <simgrid/host.h>
#endif

namespace motes::comm {

double wall_seconds() { return MPI_Wtime(); }

#ifdef MOTES_SMPI

bool simulated() { return true; }

double cpu_seconds() { return MPI_Wtime(); }

void spend(double seconds) { execute(seconds * sg_host_get_speed(sg_host_self())); }

void execute(double operations) {
  if (operations > 0) smpi_execute_flops(operations);
}

#else

bool simulated() { return false; }

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void spend(double seconds) {
  const double until = cpu_seconds() + seconds;
  while (cpu_seconds() < until) {
  }
}

void execute(double) {}

#endif

}  // namespace motes::comm
