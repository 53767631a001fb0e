"""Values: poses, joint vectors, enums, states and triggers; frozen, in SI units.

Also what client and simulator share of the controller's time, and the events of the trace hook.
"""
