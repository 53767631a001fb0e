"""A behaviour tree that runs an arm: fetch parts until there are none, recover when it fails.

    python behaviour_tree.py                      on a simulated arm, which fails once
    python behaviour_tree.py 192.168.1.10         on a real one

A leaf starts its motion when it is first ticked, and looks at its task at each further tick. A
leaf that is left stops the arm. After a failure a real arm moves again only when a person says so
at the terminal; without one the program ends. Needs py-trees.
"""

from __future__ import annotations

import argparse

import py_trees
from py_trees.common import Status

import aioduco.sync
from aioduco import Joints

PERIOD = 0.02  # between two ticks [s]
PARTS = Joints.deg(40, -10, 100, 0, -90, 0)
BOX = Joints.deg(-40, -10, 100, 0, -90, 0)


class Move(py_trees.behaviour.Behaviour):
    """A motion, as a leaf: the tree does not wait for it."""

    def __init__(self, name: str, robot: aioduco.sync.Robot, goal: Joints) -> None:
        super().__init__(name)
        self._robot, self._goal = robot, goal

    def initialise(self) -> None:
        """Begin."""
        self._task: aioduco.sync.Task | None = None

    def update(self) -> Status:
        """How it is."""
        try:
            if self._task is None:
                self._task = self._robot.motion.movej2.start(self._goal, v=0.8, a=2.0)
            if not self._task.done:
                return Status.RUNNING
            self._task.result()
        except aioduco.DucoError as error:
            print(f"{self.name}: {type(error).__name__}")
            return Status.FAILURE
        return Status.SUCCESS

    def terminate(self, new_status: Status) -> None:
        """Left before its end, it stops the arm."""
        if new_status is Status.INVALID and self._task is not None and not self._task.done:
            self._task.cancel()


class Recover(py_trees.behaviour.Behaviour):
    """Make the arm ready again, once a person has looked at it: the tree waits for both."""

    def __init__(self, robot: aioduco.sync.Robot, *, simulated: bool) -> None:
        super().__init__("recover")
        self._robot, self._simulated = robot, simulated

    def update(self) -> Status:
        """Carry it out."""
        if not self._simulated:
            input("look at the arm, then press Enter to go on: ")
        try:
            self._robot.recover()
        except aioduco.DucoError as error:
            print(f"{self.name}: {type(error).__name__}")
            return Status.FAILURE
        return Status.SUCCESS


def tree(robot: aioduco.sync.Robot, *, simulated: bool) -> py_trees.trees.BehaviourTree:
    """Fetch; if that fails, recover."""
    fetch = py_trees.composites.Sequence("fetch a part", memory=True)
    fetch.add_children([Move("to the parts", robot, PARTS), Move("to the box", robot, BOX)])
    root = py_trees.composites.Selector("work", memory=True)
    root.add_children([fetch, Recover(robot, simulated=simulated)])
    return py_trees.trees.BehaviourTree(root)


def main(host: str, port: int, *, simulated: bool = False, parts: int = 3) -> None:
    with aioduco.sync.connect(host, port) as robot:
        robot.bring_up()
        work = tree(robot, simulated=simulated)
        fetched = 0
        while fetched < parts:
            work.tick()
            if work.root.status is work.root.children[0].status is Status.SUCCESS:
                fetched += 1
                print(f"fetched {fetched} of {parts}")
            robot.sleep(PERIOD)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        main(given.host, given.port)
    else:
        import threading

        from aioduco.sim import Simulator

        with Simulator() as sim:

            def push() -> None:
                sim.wait_until(lambda: sim.joints[0] > 0.5, 60.0)
                sim.collide(joint=1)

            pusher = threading.Thread(target=push, name="somebody in the way")
            pusher.start()
            main(sim.host, sim.port, simulated=True)
            pusher.join()
