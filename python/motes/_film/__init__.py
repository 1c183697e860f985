"""Encode a film second by second while the run continues, and recover what a killed run left of it."""
