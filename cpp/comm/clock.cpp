#include "comm/clock.h"

#define OMPI_SKIP_MPICXX
#define MPICH_SKIP_MPICXX
#include <mpi.h>
#include <time.h>

namespace motes::comm {

double wall_seconds() { return MPI_Wtime(); }

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

}  // namespace motes::comm
