"""A run's log as tables, checked against their schema, and what is computed of their columns."""
