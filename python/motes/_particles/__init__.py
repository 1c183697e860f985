"""Particles as arrays: copies, views, sorting by id, and column names of other programs."""
