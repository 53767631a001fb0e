"""The arm in MuJoCo: model, world, inverse dynamics, temperatures.

It follows set-points, without a controller. May import the set-point of `planner` and what it
gives in `cycle`, and nothing else of the simulator.
"""
