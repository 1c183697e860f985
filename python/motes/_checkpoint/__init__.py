"""Checkpoints: what a run writes down between two frames, and how a later run goes on from it.

`folder`: names and places; `manifest`: what a checkpoint says about itself; `same_script`: whether it is of
this script; `finding`: the newest whole one, which all ranks agree on; `saving`: while frames go on;
`restoring`: particles and counts back into the engine; `course`: what a world does about all this.
"""
