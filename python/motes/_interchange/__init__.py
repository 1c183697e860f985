"""Particles in files that other programs open: what `Export` writes, `open_particles` reads and `pack` joins.

Reading and joining need neither MPI nor the compiled core.
"""
