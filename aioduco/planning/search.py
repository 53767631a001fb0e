"""Search of a free path from a start to one of several goals: OMPL's RRT-Connect, then shortening.

OMPL's bindings keep references, and print messages about them when the interpreter ends: so only
the process of `worker` uses this module.
"""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from aioduco.planning.spaces import PathSpace

    Points = NDArray[np.float64]

    base: Any  # its bindings are compiled
    geometric: Any
    util: Any
else:
    from ompl import base, geometric, util


STEP = 0.03
"""Between two looks at a way, at first [m of the arm's furthest point, about]."""
_RANGE = 0.5  # length of one step of a search [m, likewise]
_PATIENCE = 12_000  # looks of the first search
_SHORTCUTS = 60  # attempts at shortening


class Budget:
    """How much may be searched: looks at points, so that any computer finds the same, and a time.

    Args:
        space: space whose looks count.
        deadline: time at which the search ends at the latest, of `time.monotonic` [s].
        looks: number of looks from now on.
    """

    def __init__(self, space: PathSpace, deadline: float, looks: float = math.inf) -> None:
        self._space, self._deadline = space, deadline
        self._until = space.looks + looks

    @property
    def spent(self) -> bool:
        """Whether nothing more may be searched."""
        return self._space.looks >= self._until or time.monotonic() >= self._deadline

    def part(self, looks: float) -> Budget:
        """A part of what is left, of at most a number of looks."""
        left = self._until - self._space.looks
        return Budget(self._space, self._deadline, min(looks, left))


def seed(number: int) -> None:
    """Make the searches of this process repeatable: call it before the first one.

    Args:
        number: seed, from 1.
    """
    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(number)


def search(
    space: PathSpace,
    start: Points,
    goals: Sequence[Points],
    budget: Budget,
    *,
    direct: int = 1,
    step: float = STEP,
) -> Points | None:
    """Find a path.

    Args:
        space: space to search.
        start: a free point of it.
        goals: free points, the best first.
        budget: how much may be searched.
        direct: number of goals to which the straight path is tried.
        step: distance between two checks of a path [m of the arm's furthest point, about].

    Returns:
        Corners of the path, from the start to one of the goals. Shape (n, dimensions); None if no
        path was found within the budget.
    """
    for goal in goals[:direct]:
        if straight(space.free, start, goal, step):
            return np.array([start, goal])
    dimensions = len(start)
    ompl_space = base.RealVectorStateSpace(dimensions)
    bounds = base.RealVectorBounds(dimensions)
    ends = np.array([start, *goals])
    lower = np.maximum(space.lower, ends.min(axis=0) - space.margin)
    upper = np.minimum(space.upper, ends.max(axis=0) + space.margin)
    for axis in range(dimensions):
        bounds.setLow(axis, float(lower[axis]))
        bounds.setHigh(axis, float(upper[axis]))
    ompl_space.setBounds(bounds)
    information = base.SpaceInformation(ompl_space)
    information.setStateValidityChecker(space.free)
    information.setStateValidityCheckingResolution(step / ompl_space.getMaximumExtent())
    information.setup()

    def state(point: Points) -> Any:
        made = ompl_space.allocState()
        for axis, value in enumerate(point.tolist()):
            made[axis] = value
        return made

    problem = base.ProblemDefinition(information)
    problem.addStartState(state(start))
    wanted = base.GoalStates(information)
    for goal in goals:
        wanted.addState(state(goal))
    problem.setGoal(wanted)
    planner = geometric.RRTConnect(information)
    planner.setRange(_RANGE)
    planner.setProblemDefinition(problem)
    planner.setup()
    # Durations of such searches have a long tail: starting anew is faster than continuing.
    patience: float = _PATIENCE
    while not problem.hasExactSolution():
        if budget.spent:
            return None
        part = budget.part(patience)
        planner.clear()
        planner.solve(base.PlannerTerminationCondition(lambda part=part: part.spent))
        patience *= 1.5
    path = problem.getSolutionPath()
    shortener = geometric.PathSimplifier(information)
    shortener.reduceVertices(path)
    shortener.partialShortcutPath(path, _SHORTCUTS, _SHORTCUTS // 3)
    shortener.reduceVertices(path)
    shortener.collapseCloseVertices(path)
    corners = [path.getState(i) for i in range(path.getStateCount())]
    return np.array([[corner[axis] for axis in range(dimensions)] for corner in corners])


def straight(free: Callable[[Any], bool], start: Points, goal: Points, step: float) -> bool:
    """Tell whether the straight path between two points is free: check the middle, then finer."""
    count = max(int(np.ceil(np.linalg.norm(goal - start) / step)), 1)
    shares = np.arange(1, count) / count
    # Checks that are far apart find an obstacle soonest.
    order = np.argsort([int(f"{i:016b}"[::-1], 2) for i in range(1, count)])
    return all(free(start + shares[i] * (goal - start)) for i in order)
