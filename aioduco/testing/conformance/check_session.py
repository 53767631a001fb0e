"""A session with a controller under test: calls as they are on the wire, and waiting."""

from __future__ import annotations

import contextlib
import math
import time
from typing import TYPE_CHECKING, Any

from aioduco._process.platform import boot_time
from aioduco._wire.connection import Connection
from aioduco._wire.endpoint import Endpoint
from aioduco._wire.own_connection import OwnConnection
from aioduco._wire.rpc import Op
from aioduco.errors import (
    CallTimeout,
    ConnectionLost,
    ConnectTimeout,
    ControllerError,
    HeartbeatLost,
    NotAController,
    StopUnconfirmed,
    TaskStopped,
)
from aioduco.models.enums import RobotState, SafetyState, TaskState
from aioduco.streaming.worker.rest import bring_to_rest
from aioduco.supervision.unanswered import UnansweredMotion
from aioduco.testing.waiting import eventually

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


#: time-outs for the answer to a call that does not block, and for a small motion [s]
CALL, MOTION = 5.0, 30.0
#: seconds after which it is given up to bring the arm to rest
_REST_LIMIT = 15.0
#: seconds beyond the time-out of the call before after which the program must have stood still
_AWAY = 30.0


class Differs(Exception):
    """The controller does not behave like the simulated one. The text says what was found."""


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
        # After a missing answer, no other call can use its connection: the next one opens another.
        self._own = OwnConnection(Endpoint(host, port, CALL))
        #: until when the next call is made, unless the program stands still
        self._due = math.inf

    def open(self) -> None:
        """Connect.

        Raises:
            ConnectError: there is no controller.
        """
        try:
            self._own.call("get_robot_state", (), CALL)
        except ControllerError:  # it is one of its checks whether the controller has this function
            return
        except CallTimeout as error:
            reason = f"it accepts connections, but did not answer within {CALL:g} s"
            raise ConnectTimeout(*self.address, reason) from error
        except ConnectionLost as error:
            reason = f"what answers there is no controller ({error})"
            raise NotAController(*self.address, reason) from error

    def close(self) -> None:
        """End the connection."""
        self._own.close()

    def call(self, name: str, *args: Any, timeout: float = CALL) -> Any:
        """Call a function of the wire.

        Raises:
            DucoError: there is no answer, or the answer is an error.
            ConnectError: there is no answer, nor one to another call: no check can follow.
            HeartbeatLost: the program stood still, as in a computer that slept.
        """
        now = boot_time()
        if now > self._due:
            raise HeartbeatLost(
                f"this program stood still for {now - self._due + _AWAY:.0f} s or more: the "
                f"check ends here, and {name} was not sent. Give the command again"
            )
        self._due = now + timeout + _AWAY
        try:
            return self._own.call(name, args, timeout)
        except CallTimeout as error:
            self.require_answers(str(error))
            raise

    def require_answers(self, missing: str) -> None:
        """Check on another connection that the controller answers at all, after it did not.

        Args:
            missing: what was not answered.

        Raises:
            ConnectError: it does not.
        """
        try:
            with self.another() as connection:
                connection.call("get_robot_state", (), CALL)
        except ControllerError:
            return
        except (CallTimeout, ConnectionLost) as error:
            reason = f"it answers nothing any more ({missing}): the check ends here"
            raise ConnectTimeout(*self.address, reason) from error

    @contextlib.contextmanager
    def another(self) -> Iterator[Connection]:
        """Open a further connection."""
        connection = Connection(Endpoint(*self.address))
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

    def own_end_of(self, id_: int) -> TaskState:
        """As `end_of`, of a motion that its check lets go to its end.

        Raises:
            TaskStopped: another program has stopped or paused it.
        """
        held = (TaskState.PAUSED, TaskState.STOPPED)
        self.until(lambda: (state := self.task(id_)).ended or state in held)
        return self.let_go(id_, self.task(id_))

    def let_go(self, id_: int | None, state: int) -> TaskState:
        """Return the end of a motion that its check lets go to its end; raises as `own_end_of`."""
        if state in (TaskState.PAUSED, TaskState.STOPPED):
            what = "was stopped or paused by another program: the check ends here, the arm stands"
            raise TaskStopped("a motion", id_, what)
        return TaskState(state)

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
        """Stop the arm until it stands, and a motion that was not answered cannot move it.

        Ctrl-C does not end this, and counts afterwards.

        Raises:
            StopUnconfirmed: that is not known.
        """
        until = time.monotonic() + _REST_LIMIT
        interrupt: KeyboardInterrupt | None = None
        while True:
            try:
                stands = self._brought_to_rest(until)
                break
            except KeyboardInterrupt as again:
                interrupt = again
        if not stands:
            raise StopUnconfirmed(
                f"the arm was told to stop, but not seen to stand within {_REST_LIMIT:g} s: it may "
                "be moving. Press the emergency stop if it does"
            )
        if interrupt is not None:
            raise interrupt

    def _brought_to_rest(self, until: float) -> bool:
        now = time.monotonic()
        motion = UnansweredMotion(now, now, until)
        if self._own.idle:
            motion.answered(now)
        else:
            self._own.close()
            motion.connection_reset(now)
        return bring_to_rest(motion, self._own, CALL, lambda: None)

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

    def begun(self, id_: int | None = None) -> None:
        """Wait until the arm moves and a task, if given, has begun.

        Raises:
            Differs: they do not.
        """

        def begun() -> bool:
            return (id_ is None or self.task(id_) is not TaskState.IDLE) and self.moving()

        if not self.until(begun, 5.0):
            raise Differs("it does not move")
