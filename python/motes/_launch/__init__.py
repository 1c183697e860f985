"""Starts and supervises jobs on many ranks, from a process that is not a rank."""
