"""Shots: a picture's camera, lights, solids and sprites in the words of USD, for `Export(scene=True)`."""
