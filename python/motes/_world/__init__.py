"""A world: one run of an animation from start to end, and what all ranks agree on."""
