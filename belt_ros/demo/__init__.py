"""The main job, shown: a drive in one process, the node in another, and what it makes of it."""
