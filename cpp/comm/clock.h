// The engine's only clock: under a cluster simulator MPI keeps the time.
#pragma once

namespace motes::comm {

/// Whether this program was built for SimGrid's SMPI: ranks, their messages and the time are simulated.
bool simulated();

/// Seconds since some moment in the past, as MPI_Wtime counts them.
double wall_seconds();

/// Seconds of processor time that this thread has used. Unlike wall time it is not stretched by other processes.
/// Under a simulator: the simulated time, which passes by spend(), execute() and messages alone.
double cpu_seconds();

/// Keeps this thread busy until it has used so many seconds of processor time more.
void spend(double seconds);

/// Under a simulator, lets the time pass that this rank's machine takes for so many operations; nothing otherwise.
void execute(double operations);

}  // namespace motes::comm
