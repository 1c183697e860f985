"""How MPI begins in this process, or does not: launchers, libraries, processes that ranks start."""
