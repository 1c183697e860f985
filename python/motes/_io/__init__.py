"""Atomic writing of files, picture formats, and text for terminals."""
