"""The vendor's Python class, name for name: for programs written for it, and for its manual.

    from aioduco.compat import DucoCobot

    robot = DucoCobot("192.168.1.10", 7003)
    if robot.open() == 0:
        robot.power_on(True)
        robot.enable(True)
        robot.movej2([0.524, -0.262, 1.833, 0, -1.571, 0], 1.0, 1.0, 0.0, True)
        robot.close()

It takes the arguments of the vendor's class, sends them and returns the answer: no ranges are
checked, no motion is followed, no heartbeat is sent, and nothing is stopped when the program is
interrupted. `aioduco.connect` and `aioduco.sync.connect` do all that.

`python -m aioduco.compat program.py` runs a program that imports the vendor's class, unchanged.
"""

from __future__ import annotations

import functools
import inspect
import numbers
import threading
import warnings
from typing import TYPE_CHECKING, Any, Final, Self

import aioduco._wire.thrift  # noqa: F401 - the first call is not to wait for it
from aioduco import __version__
from aioduco._process import trial
from aioduco._process.copying import Uncopied
from aioduco._process.reporting import BackgroundLogger
from aioduco._wire.connection import Connection
from aioduco._wire.deadline_socket import WAKE_EVERY
from aioduco._wire.endpoint import Endpoint, Route
from aioduco._wire.failures import DeadlinePassed
from aioduco._wire.forks import fork_hooks
from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.lifecycle import ConnectionState
from aioduco._wire.rpc import (
    EAxisParam,
    EAxisSchemeParam,
    EAxissInfo,
    IOStatus,
    Op,
    PointOp,
    ReachabilityParam,
    RealTimeControlData,
    RobotStatus,
)
from aioduco.compat._arguments import wire_arguments
from aioduco.compat._foreign import ENUMS, as_thrift
from aioduco.compat._generated import KEYWORDS, ManualFunctions
from aioduco.compat._newer import MoveJogTaskParam
from aioduco.errors import (
    ConnectError,
    ConnectionLost,
    DucoError,
    ParameterError,
    TaskStopped,
)

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import TracebackType

__all__ = [
    "OP",
    "DucoCobot",
    "EAxisInfo",
    "EAxisParam",
    "EAxisSchemeParam",
    "EAxissInfo",
    "IOStatus",
    "IOStatusList",
    "MoveJogTaskParam",
    "MoveJogTaskParams",
    "Op",
    "OperationMode",
    "PointOP",
    "PointOp",
    "ReachabilityParam",
    "ReachabilityParams",
    "RealTimeControlData",
    "RealTimeData",
    "RobotStatus",
    "RobotStatusList",
    "SafetyState",
    "StateProgram",
    "StateRobot",
    "TaskState",
]

_log = BackgroundLogger(__name__)

#: beginnings of the names of functions by which the arm may begin to move
_MOVES: Final = (
    *("move", "tcp_move", "wobj_move", "spline", "servo", "speedj", "speedl", "replay", "resume"),
    *("teach_mode", "run_program", "trackEnqueue", "trackJointMotion", "trackCartMotion"),
    *("fc_start", "fc_move", "start_realtime_mode", "realtime_data_enqueue"),
)
#: seconds after which an unanswered stop is sent again, on a new connection
_STOP_LIMIT: Final = 1.0
#: by the address that a controller's name leads to: another object after each stop or abort by
#: this program
_last_stops: Final[dict[Any, object]] = {}

# The structs under the manual's names (section 1.2).
OP = Op
PointOP = PointOp
RobotStatusList = RobotStatus
IOStatusList = IOStatus
MoveJogTaskParams = MoveJogTaskParam
ReachabilityParams = ReachabilityParam
EAxisInfo = EAxissInfo
RealTimeData = RealTimeControlData

# The enums of the vendor's client: classes of whole numbers.
StateRobot = ENUMS["StateRobot"]
StateProgram = ENUMS["StateProgram"]
OperationMode = ENUMS["OperationMode"]
TaskState = ENUMS["TaskState"]
SafetyState = ENUMS["SafetyState"]


def _by_any_name(function: Callable[..., Any], others: dict[str, str]) -> Callable[..., Any]:
    """Make a function that takes its keyword arguments by other names, too."""

    @functools.wraps(function)
    def call(*args: Any, **keywords: Any) -> Any:
        for other in keywords.keys() & others.keys():
            if others[other] in keywords:
                raise TypeError(
                    f"{function.__name__}: {other} is another name of {others[other]}; give one"
                )
            keywords[others[other]] = keywords.pop(other)
        return function(*args, **keywords)

    return call


def _take_other_names(kind: type[ManualFunctions]) -> None:
    """Let the functions of a class take the other names of their arguments."""
    for name, function in inspect.getmembers(kind, inspect.isfunction):
        others = KEYWORDS.get(function.__name__)
        if others:
            setattr(kind, name, _by_any_name(function, others))


class DucoCobot(Uncopied, ManualFunctions):
    """A connection to a controller, with a method for each function of the manual.

    Each object is one connection, which carries one call at a time (manual 1.5.1). Any thread may
    use it: a call waits until the one before it is answered, so a call behind a blocking motion
    waits for the motion's end. `stop` does not wait: while a call is in progress, it is sent on a
    connection of its own. So is a call from a signal handler in the middle of another. A motion
    that waits behind another call when any object of the program calls `stop` or `abort` is not
    sent: `TaskStopped`.

    - A lost connection, or one that was never opened, raises `ConnectionLost`, where the vendor's
      Python class raises Thrift's `TTransportException`. If the program has imported Thrift's
      library, the error is an instance of both classes. If a motion was sent, the error is
      `OutcomeUnknown`: the arm may still move.
    - An answer that reports an error of the controller raises `ControllerError`; with Thrift's
      library imported it is also a `TApplicationException`.
    - After a lost connection, `open` makes a new one. `stop` is sent without it, on a connection of
      its own, as one that was not answered for a second is sent again. After that, and after Ctrl-C
      in the middle of a call, or what another signal's handler raises there, all calls are sent as
      before.

    Arguments have the names of the vendor's class, and by keyword those of the manual as well. For
    `q_near`, `tool` and `wobj`, None and '' stand for the present one. Structs may be the vendor's
    own objects. Bytes and words may have a sign or none, and may be `bytes`.

    Args:
        ip: name or address of the controller.
        port: its TCP port, 7003.
        timeout: maximum seconds for each call, blocking motions included; None, the vendor's
            behaviour, to wait while the connection is open. A call that takes longer raises an
            error and closes the connection, but the arm continues.

    Raises:
        ParameterError: the time is not above 0.

    Attributes:
        ip: name or address of the controller.
        port: its TCP port.
        timeout: maximum seconds for each call.
        op_: the outputs of motions that are called without outputs: none, unless it is changed.
        last_error: why `open` returned -1, or why the last call raised; None if neither.

    Manual section 1.3.1.
    """

    def __init__(self, ip: str, port: int = 7003, timeout: float | None = None) -> None:
        given: object = timeout
        number = isinstance(given, numbers.Real) and not isinstance(given, bool)
        if timeout is not None and not (number and 0.0 < timeout < threading.TIMEOUT_MAX):
            raise ParameterError("timeout", timeout, "a number above 0 s, or None")
        self.ip = ip
        self.port = port
        self.timeout = timeout
        self.op_: Op = Op(trig_io_1=1, trig_io_2=1, trig_io_3=1)
        self.last_error: DucoError | None = None
        self._route = Route()
        self._connection: Connection | None = None
        #: another object after each open() and close()
        self._session = object()
        #: whether the last call ended before its answer came: by a signal, or a stop by its limit
        self._interrupted = False
        # Held during a call. A signal handler in the middle of a call of its own thread, which
        # holds it, does not wait for itself.
        self._lock = threading.RLock()
        #: the thread that opened it, until use by another one was logged
        self._opener: threading.Thread | None = None

    def __repr__(self) -> str:
        state = "NEW" if self._connection is None else self._connection.state.name
        return f"<DucoCobot {self.ip}:{self.port} {state}>"

    def __del__(self) -> None:
        connection = getattr(self, "_connection", None)
        if connection is not None and connection.state is ConnectionState.IDLE:
            warnings.warn(f"unclosed {self!r}", ResourceWarning, source=self, stacklevel=2)
            connection.close()

    def __enter__(self) -> Self:
        if self.open() != 0:
            assert self.last_error is not None
            raise self.last_error
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def open(self) -> int:
        """Connect (打开机器人连接).

        Returns:
            0 if it is connected, -1 if not; `last_error` says why.

        Manual section 1.3.1.
        """
        connection = self._connection
        if connection is not None and connection.state is ConnectionState.ACTIVE:
            return 0
        with self._lock:
            connection = self._connection
            if connection is not None:
                if connection.state is ConnectionState.IDLE:
                    return 0
                connection.close()
            self.last_error = None
            connection = Connection(Endpoint(self.ip, self.port, route=self._route))
            try:
                connection.open()
            except (ConnectError, ConnectionLost) as exc:
                # a lost connection stays: stop is still sent, on one of its own
                self.last_error = as_thrift(exc, connected=False)
                _log.warning("open returns -1: %s", exc)
                return -1
            fork_hooks.add(self)
            self._opener = threading.current_thread()
            self._connection, self._session, self._interrupted = connection, object(), False
            return 0

    def close(self) -> int:
        """Close the connection (关闭机器人连接). It does not stop the arm.

        If another thread waits for a call, that call raises `ConnectionLost`.

        Returns:
            0, also if there was no connection.

        Manual section 1.3.1.
        """
        connection, self._connection, self._session = self._connection, None, object()
        if connection is None:
            return 0
        inside = self._held
        try:
            if not (inside or self._lock.acquire(blocking=False)):
                connection.abandon("close() was called")
                self._acquire()
            if connection.state is ConnectionState.ACTIVE:
                # in a signal handler in the middle of a call, which closes it when it resumes
                connection.abandon("close() was called")
            else:
                connection.close()
        finally:
            if not inside:
                try:  # noqa: SIM105 - an interrupt could come in `suppress`
                    self._lock.release()
                except RuntimeError:
                    pass  # interrupted before it was acquired
        return 0

    def get_version(self) -> str:
        """Return the version of this package; nothing is sent (manual section 1.3.16)."""
        return f"aioduco {__version__}"

    def get_verion(self) -> str:
        """Return the version of this package, as versions of the vendor's class spell it."""
        return self.get_version()

    def forked(self) -> None:
        """Renew the lock in a forked child: a thread that holds it exists only in the parent."""
        self._lock = threading.RLock()

    def _call(self, name: str, args: tuple[Any, ...]) -> Any:
        given = wire_arguments(name, args, self.op_)
        ended = None if trial.current is None else trial.current.call(name, args, vendor=True)
        answer: Any = None
        error: BaseException | None = None
        try:
            answer = self._send(name, given)
        except BaseException as exc:
            error = exc
            if isinstance(exc, DucoError):
                self.last_error = as_thrift(exc, connected=self._connection is not None)
            raise
        finally:
            if ended is not None:
                ended(answer, error)
        self.last_error = None
        return answer

    def _send(self, name: str, args: tuple[Any, ...]) -> Any:
        session = self._session
        if self._connection is None:
            raise ConnectionLost(f"{name} was not sent: call open() first")
        address = self._route.address
        if name in ("stop", "abort"):
            _last_stops[address] = object()
        if call_kind(name) is CallKind.STOP:
            return self._stop(name, args)
        last_stop = _last_stops.get(address)

        def permit() -> None:
            if name.startswith(_MOVES) and _last_stops.get(address) is not last_stop:
                raise TaskStopped(name, None, "was not sent, since the arm was stopped meanwhile")

        inside = self._held
        try:
            if not inside:
                self._acquire()
            if self._session is not session:
                raise ConnectionLost(f"{name} was not sent: the connection was closed")
            return self._exchange(name, args, self.timeout, permit)
        finally:
            if not inside:
                try:  # noqa: SIM105 - an interrupt could come in `suppress`
                    self._lock.release()
                except RuntimeError:
                    pass  # interrupted before it was acquired

    def _stop(self, name: str, args: tuple[Any, ...]) -> Any:
        """Stop, on a new connection if the object's own is in use, lost or silent.

        Twice does no harm.
        """
        limit = _STOP_LIMIT if self.timeout is None else min(self.timeout, _STOP_LIMIT)
        inside = self._held
        try:
            if inside or self._lock.acquire(blocking=False):
                return self._exchange(name, args, limit)
        except ConnectionLost as exc:
            # the connection was closed, so that its late answer is not taken for another
            self._interrupted |= isinstance(exc.__cause__, DeadlinePassed)
            _log.warning("%s; stop is sent on a new connection", exc)
        finally:
            if not inside:
                try:  # noqa: SIM105 - an interrupt could come in `suppress`
                    self._lock.release()
                except RuntimeError:
                    pass  # interrupted before it was acquired
        return self._send_aside(name, args)

    def _exchange(
        self,
        name: str,
        args: tuple[Any, ...],
        timeout: float | None,
        permit: Callable[[], object] | None = None,
    ) -> Any:
        """Call on the object's own connection, if no call is in progress; it holds the lock.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: maximum seconds for the call; None for no limit.
            permit: raises an error if it must not be sent, asked last before it is.
        """
        connection = self._connection
        if connection is None:
            raise ConnectionLost(f"{name} was not sent: the connection was closed")
        if connection.state is ConnectionState.ACTIVE:
            return self._send_aside(name, args, permit)
        self._notice_threads()
        if self._interrupted:
            # An answer that was not taken would be taken for that of the next call.
            connection.close()
            connection = Connection(Endpoint(self.ip, self.port, route=self._route))
            connection.open()
            self._connection, self._interrupted = connection, False
        if connection.state is not ConnectionState.IDLE:
            raise ConnectionLost(f"{name} was not sent: {connection.reason}; call open() first")
        connection.hand_over()
        try:
            return connection.call(name, args, timeout, permit)
        except DucoError:
            raise
        except BaseException:
            self._interrupted = True  # by Ctrl-C or another signal: it is not lost
            raise

    @property
    def _held(self) -> bool:
        """Whether this thread holds the lock: in a signal handler in the middle of its own call."""
        try:
            threading.Condition(self._lock).notify(0)  # wakes nobody; refused without the lock
        except RuntimeError:
            return False
        return True

    def _acquire(self) -> None:
        """Wait until the call of another thread has ended; signal handlers can run in between."""
        while not self._lock.acquire(timeout=WAKE_EVERY):
            pass

    def _send_aside(
        self, name: str, args: tuple[Any, ...], permit: Callable[[], object] | None = None
    ) -> Any:
        """Call on a new connection, while another call is in progress on the object's own one."""
        connection = Connection(Endpoint(self.ip, self.port, route=self._route))
        try:
            connection.open()
            return connection.call(name, args, self.timeout, permit)
        finally:
            connection.close()

    def _notice_threads(self) -> None:
        """Log once that several threads use this object; the caller holds the lock."""
        user, opener = threading.current_thread(), self._opener
        if opener is None or user is opener:
            return
        self._opener = None
        _log.warning(
            "%r was opened in thread %r and is used in thread %r, too: a call waits until the one "
            "before it is answered, only stop() does not. A DucoCobot for each thread does not "
            "wait (manual 1.5.1). This is said once",
            self,
            opener.name,
            user.name,
        )


_take_other_names(DucoCobot)
