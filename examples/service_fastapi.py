"""An arm as a small web service, with a stop that waits behind nothing.

    python service_fastapi.py                      a simulated arm, on http://127.0.0.1:8000
    python service_fastapi.py 192.168.1.10         a real one

    curl http://127.0.0.1:8000/state
    curl -X POST http://127.0.0.1:8000/move -H 'content-type: application/json' -d '{"to": "home"}'
    curl -X POST http://127.0.0.1:8000/stop

A motion is started and told by its number: nobody's request waits for it, and the state says how
the last one went. Who may move an arm is decided by a proxy before this, not here: it listens on
loopback. Needs fastapi and uvicorn.
"""

from __future__ import annotations

import argparse
import asyncio
from collections import deque
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import uvicorn
from fastapi import FastAPI, HTTPException
from pydantic import BaseModel

import aioduco
from aioduco import Joints

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

PLACES = {
    "home": Joints.deg(30, -15, 105, 0, -90, 0),
    "left": Joints.deg(60, -15, 105, 0, -90, 0),
    "right": Joints.deg(-60, -15, 105, 0, -90, 0),
}


class Move(BaseModel):
    """Where to, and how fast [rad/s]."""

    to: str
    v: float = 0.5


def service(host: str, port: int = 7003) -> FastAPI:
    """The service of one arm. It is connected as long as the service runs, and stands after it."""
    here: dict[str, aioduco.Robot] = {}
    last: deque[aioduco.Task] = deque(maxlen=1)
    starting = asyncio.Lock()  # two requests at once would both find an arm that is not busy

    @asynccontextmanager
    async def connected(_: FastAPI) -> AsyncIterator[None]:
        async with aioduco.connect(host, port) as robot:
            await robot.bring_up()
            here["robot"] = robot
            yield

    app = FastAPI(lifespan=connected, title="An arm")

    @app.get("/state")
    async def state() -> dict[str, Any]:
        sample = await here["robot"].feed.latest()
        return {
            "robot": sample.states.robot.name,
            "safety": sample.states.safety.name,
            "joints": list(sample.status.joints),
            "tasks": [task.name for task in here["robot"].tasks],
            "last": {"task": last[0].id, "state": last[0].state.name} if last else None,
        }

    @app.post("/move", status_code=202)
    async def move(wanted: Move) -> dict[str, Any]:
        if wanted.to not in PLACES:
            raise HTTPException(404, f"there is no place {wanted.to!r}: {', '.join(PLACES)}")
        try:
            # a stop also ends what waits here for its turn
            with here["robot"].permit("the motion"):
                async with starting:
                    if here["robot"].tasks:
                        raise HTTPException(409, "the arm is busy; stop it, or ask again")
                    motion = here["robot"].motion.movej2(PLACES[wanted.to], v=wanted.v, a=1.5)
                    last.append(task := await motion.start())
        except aioduco.ParameterError as error:
            raise HTTPException(422, str(error)) from error
        except aioduco.DucoError as error:
            raise HTTPException(503, str(error)) from error
        return {"task": task.id}

    @app.post("/stop")
    async def stop() -> dict[str, str]:
        await here["robot"].stop()
        return {"arm": "stands"}

    return app


def serve(host: str, port: int = 7003, listen: int = 8000) -> None:
    """Serve until Ctrl-C. A client that never ends its request holds up the arm's stop for 1 s."""
    uvicorn.run(service(host, port), port=listen, timeout_graceful_shutdown=1)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        serve(given.host, given.port)
    else:
        from aioduco.sim import Simulator

        with Simulator() as sim:
            serve(sim.host, sim.port)
