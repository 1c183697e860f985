"""Launchers of three MPI libraries, as `motes run` finds them."""

from __future__ import annotations

from motes._launch.starting import Mpirun, Version

FIVE = Mpirun("/opt/five/mpirun", Version("Open MPI", "5.0.11"))
FOUR = Mpirun("/opt/four/mpirun", Version("Open MPI", "4.1.4"))
HYDRA = Mpirun("/opt/mpich/mpirun", Version("MPICH", "4.0.2"))
