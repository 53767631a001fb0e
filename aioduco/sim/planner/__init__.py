"""Motion planning of the simulated controller: no clock, no thread, no physics, no wire.

Paths and their blends with set-points from a time law, and followers of targets that come while the
arm moves. May import nothing else of the simulator.
"""
