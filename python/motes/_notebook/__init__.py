"""Runs in Jupyter notebooks: the progress below a cell, and small pictures for it."""
