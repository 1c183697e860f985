"""Pictures: cameras, renderers, sprites, solids, lights, and finished frames."""
