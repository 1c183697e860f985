"""Viewing and steering a run in browsers, and replaying the recorded steering."""
