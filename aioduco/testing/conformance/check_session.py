"""A session with a controller under test: calls as they are on the wire, and waiting."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any

from aioduco._wire.connection import Connection
from aioduco._wire.lifecycle import ConnectionState
from aioduco._wire.rpc import Op
from aioduco.models.enums import RobotState, SafetyState, TaskState
from aioduco.testing.waiting import eventually

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["CheckSession", "NotTried"]

#: time-outs for the answer to a call that does not block, and for a small motion [s]
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
            DucoError: there is no answer, or the answer is an error.
        """
        if self._connection.state is not ConnectionState.IDLE:
            # After a missing answer, no other call can use the connection.
            self._connection.close()
            self._connection = Connection(*self.address)
            self._connection.open()
        return self._connection.call(name, args, timeout)

    @contextlib.contextmanager
    def another(self) -> Iterator[Connection]:
        """Open a further connection."""
        connection = Connection(*self.address)
        connection.open()
        try:
            yield connection
        finally:
            connection.close()

    # -- waiting ---------------------------------------------------------------------------------

    def until(self, condition: Callable[[], bool], seconds: float = MOTION) -> bool:
        """Wait for a condition; return whether it held in time."""
        try:
            eventually(condition, seconds)
        except AssertionError:
            return False
        return True

    def task(self, id_: int) -> TaskState:
        """State of a task."""
        return TaskState(self.call("get_noneblock_taskstate", id_))

    def end_of(self, id_: int) -> TaskState:
        """Wait for the end of a task, up to a time-out; return its state."""
        self.until(lambda: self.task(id_).ended)
        return self.task(id_)

    def moving(self) -> bool:
        """Whether the controller says that the arm moves."""
        return bool(self.call("robotmoving"))

    def joints(self) -> list[float]:
        """Actual joint angles [rad]."""
        return [float(each) for each in self.call("get_actual_joints_position")]

    def ready(self) -> None:
        """Check that the arm may be moved.

        Raises:
            NotTried: the arm is not enabled, in a safety stop, or already moving.
        """
        robot, _, safety, _ = self.call("get_robot_state")
        if (robot, safety) != (RobotState.ENABLE, SafetyState.RUN):
            raise NotTried(f"the arm is not enabled: robot state {robot}, safety state {safety}")
        if self.moving():
            raise NotTried("the arm moves")

    def rest(self) -> None:
        """Stop the arm, and wait until it stands.

        Raises:
            NotTried: the arm does not come to rest.
        """
        self.call("stop", True, timeout=MOTION)
        if not self.until(lambda: not self.moving()):
            raise NotTried("the arm does not come to rest")

    # -- motions ---------------------------------------------------------------------------------

    def turn(self, by: float, *, v: float = 0.2, r: float = 0.0, block: bool = False) -> int:
        """Turn the last joint from where it is; return the answer.

        Args:
            by: angle [rad].
            v: speed [rad/s].
            r: blend radius [m].
            block: whether the controller answers at the end of the motion.
        """
        goal = self.joints()
        goal[5] += by
        return self.move(goal, v=v, r=r, block=block)

    def move(
        self, goal: list[float], *, v: float = 0.2, r: float = 0.0, block: bool = False
    ) -> int:
        """Move to joint angles; return the answer."""
        timeout = MOTION if block else CALL
        return int(self.call("movej2", goal, v, 1.0, r, block, Op(), False, timeout=timeout))

    def moves(self, id_: int | None = None) -> bool:
        """Wait until the arm moves and a task, if given, has begun; return whether they do."""

        def begun() -> bool:
            return (id_ is None or self.task(id_) is not TaskState.IDLE) and self.moving()

        return self.until(begun, 5.0)
