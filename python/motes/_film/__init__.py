"""Encodes a film second by second while the run goes on, and recovers what a killed run has left of it."""
