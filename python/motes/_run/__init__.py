"""What happens while a script runs: how it starts, what it shows and logs, and how it ends.

`mpi_settings` is imported before MPI and NumPy start. The modules here use argument checks, errors, the
environment and the core; nothing of what scripts import.
"""
