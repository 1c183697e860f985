"""Benchmarks of this machine: `python -m motes bench NAME`."""
