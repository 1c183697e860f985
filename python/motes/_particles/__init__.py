"""Particles as arrays: copies, views, the order of ids, names that other programs give to columns."""
