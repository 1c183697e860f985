"""Runs in Jupyter notebooks: the progress below a cell, and the widget that shows and steers a run."""
