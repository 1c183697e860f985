"""A run's log as tables, checked against their schema, and measures computed from them."""
