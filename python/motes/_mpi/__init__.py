"""Whether and how MPI starts in this process: launchers, libraries, child processes of ranks."""
