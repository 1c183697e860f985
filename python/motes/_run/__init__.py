"""A running script: how it starts, what it shows and logs, and how it ends."""
