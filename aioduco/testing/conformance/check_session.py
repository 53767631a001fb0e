"""A controller that is being looked at: calls as they are on the wire, and waiting."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any

from aioduco._wire.connection import Connection
from aioduco._wire.rpc import Op
from aioduco.models.enums import RobotState, SafetyState, TaskState
from aioduco.testing.waiting import eventually

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["CheckSession", "NotTried"]

#: for an answer of a call that does not block, and for a small motion to end [s]
CALL, MOTION = 5.0, 30.0


class NotTried(Exception):
    """A check cannot be made. The text says why."""


class CheckSession:
    """Plain calls to a controller, each sent once.

    Args:
        host: address of the controller.
        port: its TCP port.
    """

    def __init__(self, host: str, port: int) -> None:
        self.address: tuple[str, int] = (host, port)
        self._connection = Connection(host, port)

    def open(self) -> None:
        """Connect.

        Raises:
            ConnectError: there is no controller.
        """
        self._connection.open()

    def close(self) -> None:
        """End the connection."""
        self._connection.close()

    def call(self, name: str, *args: Any, timeout: float = CALL) -> Any:
        """Call a function of the wire.

        Raises:
            DucoError: there is no answer, or an error instead of one.
        """
        if not self._connection.usable:
            # After an answer that did not come the connection carries no other call.
            self._connection.close()
            self._connection = Connection(*self.address)
            self._connection.open()
        return self._connection.call(name, args, timeout)

    @contextlib.contextmanager
    def another(self) -> Iterator[Connection]:
        """A further connection."""
        connection = Connection(*self.address)
        connection.open()
        try:
            yield connection
        finally:
            connection.close()

    # -- waiting ---------------------------------------------------------------------------------

    def until(self, condition: Callable[[], bool], seconds: float = MOTION) -> bool:
        """Wait for a condition; whether it came to hold in time."""
        try:
            eventually(condition, seconds)
        except AssertionError:
            return False
        return True

    def task(self, id_: int) -> TaskState:
        """State of a task."""
        return TaskState(self.call("get_noneblock_taskstate", id_))

    def end_of(self, id_: int) -> TaskState:
        """State in which a task ended, or in which it still is after a long wait."""
        self.until(lambda: self.task(id_).ended)
        return self.task(id_)

    def moving(self) -> bool:
        """Whether the controller says that the arm moves."""
        return bool(self.call("robotmoving"))

    def joints(self) -> list[float]:
        """Where the joints are [rad]."""
        return [float(each) for each in self.call("get_actual_joints_position")]

    def ready(self) -> None:
        """Check that the arm may be moved.

        Raises:
            NotTried: it is not enabled, in a safety stop, or already moving.
        """
        robot, _, safety, _ = self.call("get_robot_state")
        if (robot, safety) != (RobotState.ENABLE, SafetyState.RUN):
            raise NotTried(f"the arm is not enabled: robot state {robot}, safety state {safety}")
        if self.moving():
            raise NotTried("the arm moves")

    def rest(self) -> None:
        """Stop the arm, and wait until it stands.

        Raises:
            NotTried: it does not.
        """
        self.call("stop", True, timeout=MOTION)
        if not self.until(lambda: not self.moving()):
            raise NotTried("the arm does not come to rest")

    # -- motions ---------------------------------------------------------------------------------

    def turn(self, by: float, *, v: float = 0.2, r: float = 0.0, block: bool = False) -> int:
        """Turn the last joint from where the arm is; the answer.

        Args:
            by: angle [rad].
            v: speed [rad/s].
            r: blend radius [m].
            block: whether the answer comes at the end.
        """
        goal = self.joints()
        goal[5] += by
        return self.move(goal, v=v, r=r, block=block)

    def move(
        self, goal: list[float], *, v: float = 0.2, r: float = 0.0, block: bool = False
    ) -> int:
        """Go to joints; the answer."""
        timeout = MOTION if block else CALL
        return int(self.call("movej2", goal, v, 1.0, r, block, Op(), False, timeout=timeout))

    def moves(self, id_: int | None = None) -> bool:
        """Wait until the arm moves, by a task if one is named; whether it does."""

        def begun() -> bool:
            return (id_ is None or self.task(id_) is not TaskState.IDLE) and self.moving()

        return self.until(begun, 5.0)
