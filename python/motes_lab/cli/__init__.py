"""The laboratory's commands, one module per command, as in `motes.cli`."""
