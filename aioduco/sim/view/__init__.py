"""Pictures of the arm, and a window that shows it.

A separate process draws the pictures. The modules may import nothing else of the simulator.
"""
