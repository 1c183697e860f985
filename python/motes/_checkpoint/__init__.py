"""Checkpoints: written between two frames, and restored by a later run of the script.

`folder`: names and directories; `manifest`: a checkpoint's description; `kept`: Python's state as JSON;
`finding`: all ranks agree on the newest complete checkpoint; `saving`: writes checkpoints while frames
continue; `restoring`: loads particles and counts into the engine; `resuming`: the world's use of all this.
"""
