"""Pictures of the arm, and a window on it.

Pictures are drawn by a process of their own. May import nothing else of the simulator.
"""
