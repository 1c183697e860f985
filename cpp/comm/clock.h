// The engine's only clock: under a cluster simulator MPI keeps the time.
#pragma once

namespace motes::comm {

/// Seconds since some moment in the past, as MPI_Wtime counts them.
double wall_seconds();

/// Seconds of processor time that this thread has used. Unlike wall time it is not stretched by other processes.
double cpu_seconds();

/// Keeps this thread busy until it has used so many seconds of processor time more.
void spend(double seconds);

}  // namespace motes::comm
