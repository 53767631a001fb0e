"""The vendor's Python class, name for name: for programs written for it, and for its manual.

    from aioduco.compat import DucoCobot

    robot = DucoCobot("192.168.1.10", 7003)
    if robot.open() == 0:
        robot.power_on(True)
        robot.enable(True)
        robot.movej2([0.524, -0.262, 1.833, 0, -1.571, 0], 1.0, 1.0, 0.0, True)
        robot.close()

It sends the arguments as they are and returns the answer: no ranges are checked, no motion is
followed, no heartbeat is sent, and nothing is stopped when the program is interrupted. For all that
there are `aioduco.connect` and `aioduco.sync.connect`.
"""

from __future__ import annotations

import threading
import warnings
from typing import TYPE_CHECKING, Any

from aioduco._version import __version__
from aioduco._wire import idl
from aioduco._wire.connection import Connection
from aioduco._wire.lifecycle import ConnectionState
from aioduco._wire.rpc import (
    EAxisParam,
    EAxisSchemeParam,
    EAxissInfo,
    IOStatus,
    MoveJogTaskParam,
    Op,
    PointOp,
    ReachabilityParam,
    RealTimeControlData,
    RobotStatus,
)
from aioduco.compat._generated import ManualFunctions
from aioduco.errors import ConnectError, ConnectionLost
from aioduco.reporting import BackgroundLogger

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

    from aioduco.errors import DucoError

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
    "PointOP",
    "PointOp",
    "ReachabilityParam",
    "ReachabilityParams",
    "RealTimeControlData",
    "RealTimeData",
    "RobotStatus",
    "RobotStatusList",
]

_log = BackgroundLogger(__name__)

#: numbers that are read, and may be -1: a lost connection raises
_MAY_BE_MINUS_ONE = frozenset({"modbus_read", "read_encoder_count"})

# The structs under the manual's names (section 1.2).
OP = Op
PointOP = PointOp
RobotStatusList = RobotStatus
IOStatusList = IOStatus
MoveJogTaskParams = MoveJogTaskParam
ReachabilityParams = ReachabilityParam
EAxisInfo = EAxissInfo
RealTimeData = RealTimeControlData


class DucoCobot(ManualFunctions):
    """A connection to a controller, with a method for each function of the manual.

    Each object is one connection, used by the thread that opened it, for one call at a time
    (manual 1.5.1). To stop a motion that another object waits for, make a second object in
    another thread.

    - A function that answers with a number returns -1 if the connection is lost, or was never
      opened. So a -1 of a motion does not say that the arm stands. `last_error` says what is
      known.
    - A function that answers with something else (a list, a bool, a string, a struct, nothing)
      raises `ConnectionLost` then, since no such value means "unknown". So do `modbus_read` and
      `read_encoder_count`, of which -1 may be a true value.
    - An answer that says that the controller cannot do it raises `ControllerError`.
    - After a lost connection, `open` makes a new one.

    Args:
        ip: name or address of the controller.
        port: its TCP port, 7003.
        timeout: most seconds for each call, blocking motions included; None, as the vendor has
            it, to wait as long as the connection lives. A call that takes longer is over for this
            object, and with it the connection; not so for the arm.

    Attributes:
        ip: name or address of the controller.
        port: its TCP port.
        timeout: most seconds for each call.
        last_error: why the last call returned -1; None if it did not.

    Manual section 1.3.1.
    """

    def __init__(self, ip: str, port: int = 7003, timeout: float | None = None) -> None:
        self.ip = ip
        self.port = port
        self.timeout = timeout
        self.last_error: DucoError | None = None
        self._connection: Connection | None = None
        self._owner: int | None = None
        self._owner_name = ""

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
        """Connect (打开机器人连接); from now on only the calling thread uses this object.

        Returns:
            0 if it is connected, -1 if not; `last_error` says why.

        Raises:
            RuntimeError: another thread has opened it, and not closed it.

        Manual section 1.3.1.
        """
        connection = self._connection
        if connection is not None:
            self._check_thread("open")
            if connection.state is ConnectionState.IDLE:
                return 0
            connection.close()
        self._connection = connection = Connection(self.ip, self.port)
        self._owner, self._owner_name = threading.get_ident(), threading.current_thread().name
        self.last_error = None
        try:
            connection.open()
        except (ConnectError, ConnectionLost) as exc:
            self._connection = None
            return self._minus_one("open", exc)
        return 0

    def close(self) -> int:
        """Close the connection (关闭机器人连接). It does not stop the arm.

        Returns:
            0 if there was one, -1 if not.

        Raises:
            RuntimeError: another thread has opened it.

        Manual section 1.3.1.
        """
        if self._connection is None:
            return -1
        self._check_thread("close")
        self._connection.close()
        self._connection = None
        return 0

    def get_version(self) -> str:
        """Return the version of this package; nothing is sent (manual section 1.3.16)."""
        return f"aioduco {__version__}"

    def _check_thread(self, name: str) -> None:
        if threading.get_ident() != self._owner:
            raise RuntimeError(
                f"{name} was called in thread {threading.current_thread().name!r}, but thread "
                f"{self._owner_name!r} opened {self!r}; nothing was sent. One object is for one "
                "thread (manual 1.5.1): make another DucoCobot in this one"
            )

    def _send(self, name: str, args: tuple[Any, ...]) -> Any:
        connection = self._connection
        if connection is None:
            raise ConnectionLost(f"{name} was not sent: call open() first")
        self._check_thread(name)
        answer = connection.call(name, _plain(name, args), self.timeout)
        self.last_error = None
        return answer

    def _call(self, name: str, args: tuple[Any, ...]) -> Any:
        try:
            return self._send(name, args)
        except ConnectionLost as exc:
            if not idl.functions()[name].number or name in _MAY_BE_MINUS_ONE:
                raise
            return self._minus_one(name, exc)

    def _minus_one(self, name: str, error: DucoError) -> int:
        self.last_error = error
        _log.warning("%s returns -1: %s", name, error)
        return -1


def _plain(name: str, args: tuple[Any, ...]) -> tuple[Any, ...]:
    """The arguments with True and False as the 1 and 0 that they are to the vendor's class."""
    whole = idl.functions()[name].whole
    return tuple(
        int(value) if isinstance(value, bool) and index in whole else value
        for index, value in enumerate(args)
    )
