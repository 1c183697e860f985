"""Reproduces tables 1 to 3 of the paper with the real engine on a simulation of its cluster."""
