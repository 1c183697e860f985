"""What pictures look like, and frames: cameras, renderers, sprites, solids, lights."""
