"""The process that plans: `python -m aioduco.planning.worker SEED`, started by a `Planner`.

It reads pickles from its standard input: MuJoCo's model of a scene with the positions in it, or a
problem. The answer to a problem is a solution, or the error that says why there is none. It ends
when its input does; OMPL's bindings then have no chance to complain of what they leave behind.
"""

from __future__ import annotations

import contextlib
import os
import sys
from typing import IO

from aioduco.errors import PlanningError
from aioduco.planning.collision import CollisionChecker
from aioduco.planning.exchange import WorkerScene, receive, send
from aioduco.planning.problem import PlanningProblem
from aioduco.planning.search import seed
from aioduco.planning.solver import solve

__all__ = ["main", "serve"]


def serve(requests: IO[bytes], answers: IO[bytes]) -> None:
    """Answer until the requests end."""
    checker: CollisionChecker | None = None
    while True:
        request = receive(requests)
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
        send(answers, answer)


def main() -> None:
    """Serve on standard input and output."""
    output = os.dup(1)
    os.dup2(2, 1)  # what a library prints is no answer
    seed(int(sys.argv[1]))
    with contextlib.suppress(KeyboardInterrupt, EOFError, OSError), os.fdopen(output, "wb") as out:
        serve(sys.stdin.buffer, out)
    os._exit(0)


if __name__ == "__main__":
    main()
