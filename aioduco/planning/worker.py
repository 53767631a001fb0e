"""The process that plans, started by a `Planner`.

First it reports that it has started. Then it receives values over its channel: first the seed of
the search, then scenes (MuJoCo's model, with positions) and problems. It answers a problem with a
solution, or with the error that says why there is none. It exits when its channel closes, by
`os._exit`, so that OMPL's bindings do not print messages about objects that they leave behind.
"""

from __future__ import annotations

import contextlib
import os

from aioduco._process.linked_process import ValueChannel
from aioduco.errors import PlanningError
from aioduco.planning.collision import CollisionChecker
from aioduco.planning.problem import PlanningProblem, WorkerScene
from aioduco.planning.search import seed
from aioduco.planning.solver import solve


def serve(channel: ValueChannel) -> None:
    """Answer problems until the channel closes."""
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
        serve(ValueChannel.of(arguments))
    os._exit(0)
