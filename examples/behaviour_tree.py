"""A behaviour tree that runs an arm: fetch parts until there are none, recover when it fails.

    python behaviour_tree.py                      on a simulated arm, which fails once
    python behaviour_tree.py 192.168.1.10         on a real one

A leaf starts its motion when it is first ticked, and looks at its task at each further tick: the
tree never waits. A leaf that is left stops the arm. After a failure a real arm moves again only
when a person says so at the terminal; without one the program ends. Needs py-trees.
"""

from __future__ import annotations

import argparse
from functools import partial
from typing import TYPE_CHECKING

import anyio
import py_trees
from py_trees.common import Status

import aioduco
from aioduco import Joints

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

PERIOD = 0.02  # between two ticks [s]
PARTS = Joints.deg(40, -10, 100, 0, -90, 0)
BOX = Joints.deg(-40, -10, 100, 0, -90, 0)


class Leaf(py_trees.behaviour.Behaviour):
    """Something awaited, as a leaf.

    Args:
        name: of the leaf.
        tasks: where it runs.
        call: what is awaited anew each time.
    """

    def __init__(
        self, name: str, tasks: anyio.abc.TaskGroup, call: Callable[[], Awaitable[object]]
    ) -> None:
        super().__init__(name)
        self._tasks, self._call = tasks, call
        self._scope = anyio.CancelScope()

    def initialise(self) -> None:
        """Begin."""
        self._result = Status.RUNNING
        self._scope = anyio.CancelScope()
        self._tasks.start_soon(self._run, self._scope)

    def update(self) -> Status:
        """How it is."""
        return self._result

    def terminate(self, new_status: Status) -> None:
        """Left before its end, it is cancelled: the arm comes to rest."""
        if new_status is Status.INVALID:
            self._scope.cancel()

    async def _run(self, scope: anyio.CancelScope) -> None:
        with scope:
            try:
                await self._call()
                self._result = Status.SUCCESS
            except aioduco.DucoError as error:
                print(f"{self.name}: {type(error).__name__}")
                self._result = Status.FAILURE


def tree(
    robot: aioduco.Robot, tasks: anyio.abc.TaskGroup, *, simulated: bool
) -> py_trees.trees.BehaviourTree:
    """Fetch; if that fails, recover."""

    def go(goal: Joints) -> Callable[[], Awaitable[object]]:
        return lambda: robot.motion.movej2(goal, v=0.8, a=2.0)

    async def recover() -> None:
        if not simulated:
            await anyio.to_thread.run_sync(input, "look at the arm, then press Enter to go on: ")
        await robot.recover()

    fetch = py_trees.composites.Sequence("fetch a part", memory=True)
    fetch.add_children([Leaf("to the parts", tasks, go(PARTS)), Leaf("to the box", tasks, go(BOX))])
    root = py_trees.composites.Selector("work", memory=True)
    root.add_children([fetch, Leaf("recover", tasks, recover)])
    return py_trees.trees.BehaviourTree(root)


async def main(host: str, port: int, *, simulated: bool = False, parts: int = 3) -> None:
    async with aioduco.connect(host, port) as robot, anyio.create_task_group() as tasks:
        await robot.bring_up()
        work, start = tree(robot, tasks, simulated=simulated), anyio.current_time()
        fetched = number = 0
        while fetched < parts:
            work.tick()
            if work.root.status is work.root.children[0].status is Status.SUCCESS:
                fetched += 1
                print(f"fetched {fetched} of {parts}")
            number = max(number + 1, int((anyio.current_time() - start) / PERIOD))
            await anyio.sleep_until(start + number * PERIOD)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        anyio.run(main, given.host, given.port)
    else:
        import threading

        from aioduco.sim import Simulator

        with Simulator() as sim:

            def push() -> None:
                sim.wait_until(lambda: sim.joints[0] > 0.5, 60.0)
                sim.collide(joint=1)

            pusher = threading.Thread(target=push, name="somebody in the way")
            pusher.start()
            anyio.run(partial(main, sim.host, sim.port, simulated=True))
            pusher.join()
