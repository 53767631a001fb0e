"""The arm in MuJoCo: model, world, inverse dynamics, temperatures.

It follows set-points and contains no controller. It may import the set-point of `planner` and the
types of its readings in `cycle`, and nothing else of the simulator.
"""
