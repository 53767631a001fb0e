"""What the trial of a program changes in simulated controllers: see `aioduco.testing.preflight`.

As in `aioduco._process.trial`, there is a trial in the process of a preflight alone.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.kinematics import Arm
    from aioduco.models.pose import JointsLike
    from aioduco.sim.controller.motion_queue import Plan
    from aioduco.sim.scene import MountingLike, SceneLike


class ControllerTrial(ABC):
    """What simulated controllers ask or tell in the process of a trial."""

    @abstractmethod
    def made(
        self,
        arm: Arm,
        joints: JointsLike,
        *,
        scene: SceneLike | None,
        tool: SceneLike | None,
        gripper: str | None,
        mounting: MountingLike,
        pedestal: float,
    ) -> tuple[JointsLike, float, float]:
        """A simulator is being made, of these arguments of `Simulator`.

        Returns:
            Its joints at the start [rad], the duration of its cycle [s], and its speed.
        """

    @abstractmethod
    def started(self, simulator: object) -> None:
        """A `Simulator` has started."""

    @abstractmethod
    def closing(self, simulator: object) -> None:
        """A `Simulator` is about to close."""

    @abstractmethod
    def answer(self, name: str, answer: Callable[[], bytes]) -> bytes:
        """Answer a client's call by `answer`, on the thread of its connection.

        Args:
            name: the function of the wire.
            answer: carries it out, and returns the encoded answer.
        """

    @abstractmethod
    def task(self, number: int) -> None:
        """A task was made: by the call that is answered on this thread, if there is one."""

    @abstractmethod
    def waiting(self) -> AbstractContextManager[object]:
        """A block in which the call that is answered on this thread waits for the end of a task."""

    @abstractmethod
    def planned(self, name: str, arm: Arm, plan: Plan) -> Plan:
        """The plan of a motion, or another in its place.

        Args:
            name: the function of the wire that is answered on this thread.
            arm: the arm.
            plan: its plan.
        """

    @abstractmethod
    def passes_over(self) -> bool:
        """Whether the arm moves on a path that is not the program's: no collision counts there."""


#: the trial that this process carries out; None in every process but that of a preflight
current: ControllerTrial | None = None


def waiting() -> AbstractContextManager[object]:
    """A block in which the call that is answered on this thread waits for the end of a task."""
    return nullcontext() if current is None else current.waiting()
