"""A world: one run of an animation from its start to its end, with all that all ranks agree on."""
