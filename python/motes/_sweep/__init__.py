"""Many runs of one script with different values: the grid, the runs, their table; see `cli/sweep.py`."""
