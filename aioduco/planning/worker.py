"""The process that plans, started by a `Planner`.

First it reports that it has started. Then it receives values over its channel: first the seed of
the search, then scenes (MuJoCo's model, with positions) and problems. It answers a problem with a
solution, or with the error that says why there is none. It exits when its channel closes, by
`os._exit`, so that OMPL's bindings do not print messages about objects that they leave behind.
"""

from __future__ import annotations

import contextlib
import os
import sys
from types import ModuleType
from typing import TYPE_CHECKING

from aioduco._process.linked_process import ValueChannel
from aioduco.errors import PlanningError
from aioduco.planning.collision import CollisionChecker
from aioduco.planning.problem import PlanningProblem, WorkerScene
from aioduco.planning.search import seed

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.planning.problem import Solution

    Solver = Callable[[PlanningProblem, CollisionChecker], Solution]

__all__ = ["load", "main", "serve"]


def load() -> Solver:
    """Import the solver without matplotlib, and return it.

    TOPP-RA imports matplotlib for plots that nobody makes in this process. That would take a third
    of the time until the process has started, and 30 MB.
    """
    for name in ("matplotlib", "matplotlib.pyplot"):
        sys.modules.setdefault(name, ModuleType(name))
    from aioduco.planning.solver import solve  # noqa: PLC0415  # it imports TOPP-RA

    return solve


def serve(channel: ValueChannel, solve: Solver) -> None:
    """Answer problems by a solver until the channel closes."""
    channel.send(None)
    seed(channel.receive())
    checker: CollisionChecker | None = None
    while True:
        request = channel.receive()
        if isinstance(request, WorkerScene):
            checker = CollisionChecker(request.model, 0.0, request.positions)
            continue
        assert isinstance(request, PlanningProblem)
        assert checker is not None
        try:
            checker.padding = request.padding
            answer: object = solve(request, checker)
        except PlanningError as error:
            answer = error
        except Exception as error:  # reported to the process that asked
            answer = PlanningError(f"the planner failed: {error!r}")
        channel.send(answer)


def main(arguments: list[str]) -> int:
    """Serve the program that started this process, then exit."""
    with contextlib.suppress(KeyboardInterrupt, EOFError, OSError):
        serve(ValueChannel.of(arguments), load())
    os._exit(0)
