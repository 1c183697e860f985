"""Tables 1 to 3 of the paper, again: its cluster is simulated, the engine is real."""
