"""Motion planning of the simulated controller: no clock, no thread, no physics, no wire.

It holds paths and their blends, with set-points from a time law, and followers of targets that
arrive while the arm moves. It may import no other part of the simulator.
"""
