"""Errors: each says what was wrong, what was or was not done to the arm, and what to do."""

from __future__ import annotations

import contextlib
import copy
import sys
from typing import TYPE_CHECKING, Any, TypeVar, cast

from aioduco.models.host_port import host_port

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from typing import Self

__all__ = [
    "BusError",
    "CalibrationError",
    "CallTimeout",
    "CameraError",
    "CellFileError",
    "ConnectError",
    "ConnectTimeout",
    "ConnectionLost",
    "ControllerError",
    "DucoError",
    "EnvelopeViolated",
    "FeedOverflow",
    "FirstPointTooFar",
    "GoalInCollision",
    "GoalOutOfReach",
    "GoalToleranceViolated",
    "GripperError",
    "GripperFault",
    "GripperNotActivated",
    "GripperTimeout",
    "GuardLost",
    "HeartbeatLost",
    "HoldUnknown",
    "LayoutUnknown",
    "MissingExtra",
    "ModbusError",
    "ModbusGarbled",
    "ModbusRefused",
    "ModbusTimeout",
    "MotionCarriedOut",
    "NamedElsewhere",
    "NoPathFound",
    "NotAController",
    "NotCopyable",
    "NotSent",
    "ObjectLost",
    "OutcomeUnknown",
    "ParameterError",
    "PathIncomplete",
    "PathRefused",
    "PathToleranceViolated",
    "PersonNeeded",
    "PlanObstructed",
    "PlanningError",
    "ProtocolError",
    "RecordingError",
    "Refused",
    "RenderError",
    "RobotStateError",
    "SceneError",
    "SetPointTooFar",
    "StaleState",
    "StartInCollision",
    "StopUnconfirmed",
    "StopsUnconfirmed",
    "StreamClosed",
    "StreamError",
    "StreamLeavesEnvelope",
    "StreamLost",
    "StreamRefused",
    "StreamStarved",
    "StreamStopped",
    "TaskError",
    "TaskFailed",
    "TaskIllegal",
    "TaskInterrupted",
    "TaskOverdue",
    "TaskParameterMismatch",
    "TaskStopped",
    "TaskUnknown",
    "TrackPoolFull",
    "UnitWarning",
    "UnknownFunction",
    "Unreachable",
    "WaypointFileError",
    "WorkerFailed",
    "WrongLoop",
    "WrongProcess",
]


_Error = TypeVar("_Error", bound="Portable")
#: characters of a wrong value that a message shows
_LONGEST_VALUE = 500


class Portable(Exception):
    """Base of exceptions whose copies and pickles have the same class, text and attributes.

    An attribute that cannot be pickled, such as a lock, is pickled as a stand-in with its `repr`.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        # without __init__, which takes other arguments than the text that is in args
        arguments, fields = self._parts()
        return _restored, (
            type(self),
            tuple(map(_pickleable, arguments)),
            {name: _pickleable(value) for name, value in fields.items()},
        )

    def __copy__(self) -> Self:
        return _restored(type(self), *self._parts())

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        arguments, fields = self._parts()
        return _restored(
            type(self),
            tuple(_copied(value, memo) for value in arguments),
            {name: _copied(value, memo) for name, value in fields.items()},
        )

    def _parts(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        """The arguments of the base class, and the attributes, also those of a builtin base."""
        reduced = cast("tuple[Any, ...]", super().__reduce__())
        return reduced[1], reduced[2] if len(reduced) > 2 else {}


class DucoError(Portable):
    """Base of all errors of this package.

    A copy, and one that comes back from another process, has the same class, text and attributes.
    """


class Described(str):
    """A value in words, such as "3 views". Errors have it without quotation marks."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


class ParameterError(DucoError, ValueError):
    """An argument is outside what the manual allows. Nothing was sent.

    Attributes:
        parameter: the name of the parameter.
        value: the value that was given.
        expected: the allowed values, with the unit.
    """

    def __init__(self, parameter: str, value: object, expected: str) -> None:
        self.parameter = parameter
        self.value = value
        self.expected = expected
        end = " Nothing was sent" if expected.endswith("?") else "; nothing was sent"
        super().__init__(f"{parameter} is {_text(value)}, but must be {expected}{end}")


class MotionCarriedOut(DucoError, TypeError):
    """The outcome of a motion was given or used as a motion: **the arm has already moved**.

    The motion was carried out before this call. Nothing that was given to this call was sent.

    Attributes:
        parameter: the name of the parameter.
        outcome: how the motion ended.
    """

    def __init__(self, parameter: str, outcome: object, meant: str) -> None:
        self.parameter = parameter
        self.outcome = outcome
        super().__init__(
            f"{parameter} is {outcome!r}, how a motion ended: it was carried out before this call, "
            f"and the arm has moved. {meant}. Nothing further was sent"
        )


class NamedElsewhere(DucoError, AttributeError):
    """A function of the manual was looked up on an object without it; nothing was sent.

    Attributes:
        function: the name that was looked up.
        meant: where the function is.
    """

    def __init__(self, function: str, meant: str) -> None:
        self.function = function
        self.meant = meant
        super().__init__(f"{function} is {meant}")


class ConnectError(DucoError, ConnectionError):
    """No connection to a controller could be made. Nothing was sent.

    Attributes:
        host: address that was tried.
        port: TCP port that was tried; 0: the address has it.
    """

    def __init__(self, host: str, port: int, reason: str) -> None:
        self.host = host
        self.port = port
        where = host_port(host, port) if port else host
        super().__init__(f"cannot connect to {where}: {reason}")


class ConnectTimeout(ConnectError, TimeoutError):
    """Something accepted the connection, but answered no call in time."""


class NotAController(ConnectError):
    """The program that listens at the address does not speak the controller's protocol."""


class ConnectionLost(DucoError, ConnectionError):
    """The connection broke, or was closed, before or during a call.

    For a function that only reads, nothing happened and it may be called again. A command
    whose reply was lost raises `OutcomeUnknown` instead.
    """


class CallTimeout(ConnectionLost, TimeoutError):
    """A function that only reads was not answered within its deadline.

    The connection was closed, so that no later call can receive the late answer.
    """


class NotSent(ConnectionLost, TimeoutError):
    """The time for a call was over before any of it was sent. Nothing happened.

    Every connection of its lane was in use, or a new one could not be opened in time.
    """


class OutcomeUnknown(ConnectionLost):
    """A command was sent, but its reply never came: it may or may not have been carried out.

    The package never sends it again, unless it is a stop. Read the robot's state before you decide
    what to do.

    Attributes:
        function: the function of the wire that was called.
        reason: why its reply is not known.
    """

    def __init__(self, function: str, reason: str) -> None:
        self.function = function
        self.reason = reason
        super().__init__(
            f"{function} was sent, but {reason}: it may or may not have been carried out; "
            "only a stop is ever sent again. Read the robot's state before you repeat it"
        )


class ProtocolError(ConnectionLost):
    """The other side sent bytes that are no answer to this call. The connection was closed."""


class ControllerError(DucoError):
    """The controller answered a call with a Thrift application error.

    Attributes:
        function: the function of the wire that was called.
        code: the application error's type.
    """

    def __init__(self, function: str, message: str, code: int = 0) -> None:
        self.function = function
        self.code = code
        super().__init__(f"{function}: {message}")


class UnknownFunction(ControllerError):
    """The controller does not have this function: its software is older than the function.

    Nothing was done. The documentation's table of functions says which ones older controllers lack.

    Attributes:
        version: the version of the controller's software; empty if it is not known.
    """

    def __init__(self, function: str, message: str, code: int = 1, *, version: str = "") -> None:
        self.version = version
        known = f", version {version}," if version else ""
        super().__init__(
            function,
            f"this controller{known} has no such function, and did nothing ({message}); "
            "its software is older than the function",
            code,
        )
        self._message = message

    def of(self, version: str) -> UnknownFunction:
        """Return the same error with the controller's version."""
        return UnknownFunction(self.function, self._message, self.code, version=version)


class LayoutUnknown(DucoError):
    """How the controller's version takes the arguments of a function is not known.

    Nothing was sent.

    Attributes:
        function: the function of the wire.
        version: the version of the controller's software.
    """

    def __init__(self, function: str, version: str, known: str) -> None:
        self.function = function
        self.version = version
        super().__init__(
            f"{function}: how a controller of version {version} takes its arguments is not known: "
            f"{known}; nothing was sent"
        )


class Refused(DucoError):
    """The controller refused a call by its return value.

    Attributes:
        function: the function of the wire that was called.
        code: the value that it returned: a number, or, from a function that reads, an empty value
            such as an empty text.
    """

    def __init__(self, function: str, code: object, reason: str) -> None:
        self.function = function
        self.code = code
        super().__init__(f"the controller refused {function} (answer {code!r}): {reason}")


class BusError(DucoError):
    """The controller could not write to a bus: RS-485 or CAN.

    Attributes:
        function: the function of the wire that was called.
    """

    def __init__(self, function: str) -> None:
        self.function = function
        super().__init__(
            f"{function} failed: the controller says that the bytes were not written to the bus"
        )


class ModbusError(DucoError):
    """A device on RS-485 did not carry out a Modbus request, or it is not known whether it did."""


class ModbusRefused(ModbusError):
    """The device answered a request with a Modbus exception: it did not carry it out.

    Attributes:
        function: the requested Modbus function.
        code: the exception's code.
    """

    def __init__(self, function: int, code: int, meaning: str) -> None:
        self.function = function
        self.code = code
        super().__init__(
            f"the device refused Modbus function {function:#04x}: exception {code}, {meaning}"
        )


class ModbusTimeout(ModbusError, TimeoutError):
    """The device did not answer in time. A write may or may not have been carried out.

    Check the wiring, the bit rate and the number of the device. The package does not repeat the
    request.
    """


class ModbusGarbled(ModbusError):
    """The received bytes are no answer to the request: wrong checksum, or another device's bytes.

    A write may or may not have been carried out. The package does not repeat the request.
    """


class GripperError(DucoError):
    """A gripper did not carry out a command. Mostly raised as one of the subclasses."""


class GripperNotActivated(GripperError):
    """The gripper must be activated after power-on before it can move; nothing moved.

    `await gripper.activate()` activates it. The fingers may then travel their full stroke.
    """


class GripperFault(GripperError):
    """The gripper has a fault.

    Attributes:
        code: the fault's code.
    """

    def __init__(self, gripper: str, code: int, meaning: str) -> None:
        self.code = code
        super().__init__(f"{gripper} has fault {code:#04x}: {meaning}")


class GripperTimeout(GripperError, TimeoutError):
    """The gripper did not come to rest in time, or its sensor did not react to the output."""


class ObjectLost(GripperError):
    """The gripper does not hold what it gripped, or has gripped nothing."""


class HoldUnknown(GripperError):
    """The gripper does not report any more whether it holds what it gripped.

    It does not answer, has a fault, or was without power. Look at it before the arm moves on.
    """


class TrackPoolFull(Refused):
    """The track pool has no room for the points.

    The manual does not say whether the points that fit were added: `getQueueSize` returns how many
    points the pool holds. Wait until the arm has taken some, or empty the pool (`trackClearQueue`).
    """

    def __init__(self, function: str, code: int) -> None:
        super().__init__(function, code, "the track pool, of 1000 points, has no room for them")


class RobotStateError(DucoError):
    """The robot's state does not allow the call."""


class PersonNeeded(RobotStateError):
    """Only a person can bring the robot out of its state; the message says what to do."""


class WrongLoop(RobotStateError):
    """The robot is used outside of the event loop on which it was opened. Nothing was sent.

    The robot continues undisturbed on its own loop.
    """


class WrongProcess(RobotStateError):
    """A robot or a planner is used in a child that was forked from the process that opened it.

    Nothing was sent. It continues undisturbed in the parent.
    """


class GuardLost(DucoError):
    """The guard's process could not be started, or has ended. The arm is stopped in other ways."""


class HeartbeatLost(RobotStateError):
    """The heartbeat is not running, so no motion may be started."""


class StopUnconfirmed(DucoError):
    """A stop was requested, but it is not known that the arm stands.

    This is the only error that requires a person at the emergency stop.
    """


class StopsUnconfirmed(StopUnconfirmed):
    """A stop of several arms was requested, but it is not known that all of them stand.

    Attributes:
        errors: for each robot, in the order in which they were given, why its standstill is not
            known; None for a robot that stands.
    """

    def __init__(self, message: str, errors: tuple[DucoError | None, ...]) -> None:
        super().__init__(message)
        self.errors = errors

    @classmethod
    def of(cls, places: Sequence[str], errors: Sequence[DucoError | None]) -> StopsUnconfirmed:
        """Make the error from the addresses of the robots and the error of each."""
        pairs = zip(places, errors, strict=True)
        said = [f"{place}: {error}" for place, error in pairs if error is not None]
        return cls(
            f"of {len(said)} of {len(places)} arms it is not known that they stand: "
            + "; ".join(said),
            tuple(errors),
        )


class FeedOverflow(DucoError):
    """A subscriber that wants every item did not take them in time: some are missing."""


class StaleState(DucoError):
    """The newest sample of the robot's state is older than allowed."""


class TaskError(DucoError):
    """A task did not finish.

    Attributes:
        task_id: the controller's id of the task; None if it never sent one.
        name: the function that started it.
        errors: entries that the controller's error list had gained when the task ended.
    """

    def __init__(
        self, name: str, task_id: int | None, message: str, errors: Sequence[str] = ()
    ) -> None:
        self.name = name
        self.task_id = task_id
        self.errors: tuple[str, ...] = tuple(errors)
        listed = f"; the controller's errors: {'; '.join(self.errors)}" if self.errors else ""
        which = name if task_id is None else f"{name} (task {task_id})"
        super().__init__(f"{which} {message}{listed}")


class TaskStopped(TaskError):
    """The task was ended by a stop. The arm stands."""


class TaskOverdue(TaskStopped, TimeoutError):
    """The task did not end by its deadline, and the arm was stopped."""


class TaskUnknown(TaskError, ConnectionLost):
    """The task could not be followed any more: it may have ended, or may be running."""


class TaskInterrupted(TaskError):
    """The task was interrupted before its end, other than by blending into the next one."""


class TaskFailed(TaskError):
    """The controller ended the task with an error."""


class TaskIllegal(TaskError):
    """The task is not allowed in the robot's state: not enabled, stopped, unknown tool, …"""


class TaskParameterMismatch(TaskError):
    """The controller rejected a parameter of the task."""


class Unreachable(DucoError):
    """No configuration of the arm reaches a pose, according to the inverse kinematics.

    It is that of this computer, or the controller's (`cal_ikine`). Nothing was moved.
    """


class EnvelopeViolated(DucoError):
    """A motion would lead beyond a limit of `robot.envelope`, or not back from it. It was not sent.

    Attributes:
        limit: the name of the limit.
        body: the part that would be beyond it: "tool", "elbow", "flange", a joint, or the arm.
        place: its position in the base frame [m]; NaN if the limit has no position.
        margin: distance to the limit, negative beyond it [m, rad, m/s, N], or without a unit for a
            singularity.
    """

    def __init__(
        self,
        message: str,
        limit: str,
        body: str,
        place: tuple[float, float, float],
        margin: float,
    ) -> None:
        self.limit = limit
        self.body = body
        self.place = place
        self.margin = margin
        super().__init__(message)


class PlanningError(DucoError):
    """No plan was made. Nothing was sent, and nothing moved.

    Attributes:
        pair: names of the two bodies that collide; None if the error is not about a collision.
        joints: the configuration concerned [rad]; None if there is none.
    """

    def __init__(
        self,
        message: str,
        *,
        pair: tuple[str, str] | None = None,
        joints: Sequence[float] | None = None,
    ) -> None:
        self.pair = pair
        self.joints: tuple[float, ...] | None = None if joints is None else tuple(joints)
        super().__init__(message)


class StartInCollision(PlanningError):
    """The arm touches something where a plan is to begin. `pair` names the two bodies."""


class GoalInCollision(PlanningError):
    """The arm would touch something at each of its goals. `pair` names the two bodies."""


class GoalOutOfReach(PlanningError, Unreachable):
    """No configuration of the arm reaches a goal, within its joint limits and constraints."""


class NoPathFound(PlanningError, TimeoutError):
    """Start and goal are free, but no path between them was found in the given time.

    This does not prove that there is none.
    """


class PathIncomplete(PlanningError):
    """Only a part of a line or an arc of the tool is free and within reach.

    Attributes:
        fraction: that part of the line or arc, 0 to 1.
    """

    def __init__(
        self,
        message: str,
        *,
        fraction: float = 0.0,
        pair: tuple[str, str] | None = None,
        joints: Sequence[float] | None = None,
    ) -> None:
        self.fraction = fraction
        super().__init__(message, pair=pair, joints=joints)


class PlanObstructed(PlanningError):
    """The arm would touch something on its planned path, in the scene as it is now.

    If this is raised while a plan is carried out, the arm was first brought to rest on its path.
    """


class SetPointTooFar(ParameterError):
    """A set-point is further from the previous one than a stream allows. It was not sent.

    The stream continues: the arm stays at the previous set-point.
    """


class StreamError(DucoError):
    """A stream ended although its program had not closed it.

    Attributes:
        statistics: the stream's statistics at its end; None if it never began.
    """

    def __init__(self, message: str, statistics: object = None) -> None:
        self.statistics = statistics
        super().__init__(message)


class StreamClosed(StreamError):
    """The stream was closed, and accepts no more set-points."""


class StreamStarved(StreamError):
    """The program sent no set-point in time, or hung, or its heartbeat was lost.

    The arm was brought to rest, and stopped.
    """


class StreamStopped(StreamError):
    """The robot was stopped while the stream ran. The stream sends nothing more."""


class StreamRefused(StreamError):
    """The controller refused a set-point, or left the state in which it follows them.

    Or another program's motion moved the arm when the stream was to begin: nothing was sent.
    """


class StreamLost(StreamError, ConnectionLost):
    """The stream's connection broke, or an answer did not come in time. A stop was attempted."""


class FirstPointTooFar(StreamError):
    """The first set-point was too far from where the arm was. Nothing was sent."""


class WorkerFailed(StreamError):
    """The stream's worker ended by an internal error, stood still for too long, or was killed."""


class PathToleranceViolated(StreamError):
    """The arm deviated from its trajectory. It was brought to rest, and stopped."""


class GoalToleranceViolated(StreamError):
    """The arm did not come close enough to the end of its trajectory in time. It stands."""


class StreamLeavesEnvelope(StreamError, EnvelopeViolated):
    """A stream was ended by a limit of `robot.envelope`, which it names.

    Either a set-point would have passed it, or the arm could not have stopped before it: it was not
    sent, and the arm was brought to rest before the limit, and stopped. Or the arm itself was
    beyond it, and was stopped. The message says which.
    """

    def __init__(
        self,
        message: str,
        limit: str,
        body: str,
        place: tuple[float, float, float],
        margin: float,
        statistics: object = None,
    ) -> None:
        EnvelopeViolated.__init__(self, message, limit, body, place, margin)
        self.statistics = statistics


class SceneError(DucoError, ValueError):
    """A scene, a tool or a mounting cannot be simulated. No simulator was started."""


class UnitWarning(UserWarning):
    """A number looks as if it was given in a wrong unit; it was used as it is.

    Python shows this once for each line of a program.
    """


class RenderError(DucoError, RuntimeError):
    """This computer cannot draw a picture, or show a window. The simulator continues without it."""


class CameraError(DucoError, OSError):
    """A camera gives no picture: it is missing, or was unplugged. Nothing was done to the arm."""


class CalibrationError(DucoError, ValueError):
    """Measurements do not determine a camera's pose, a tool, a load or an arm. It says why."""


class RecordingError(DucoError):
    """A recording cannot be written, read or played. Motions that the message names took place."""


class PathRefused(DucoError):
    """A check found a reason not to move the arm along a recorded path or to waypoints.

    Nothing was sent.

    Attributes:
        findings: the reasons, each with its place.
    """

    def __init__(self, message: str, findings: tuple[str, ...]) -> None:
        self.findings = findings
        super().__init__(message)


class WaypointFileError(DucoError, ValueError):
    """A file of waypoints cannot be read or written. The message has the line and the field.

    Nothing was sent.
    """


class CellFileError(DucoError, ValueError):
    """The file of a cell cannot be read or written. The message has the line and the field.

    Nothing was sent.
    """


class NotCopyable(DucoError, TypeError):
    """An object that holds a connection, a process or a device was to be copied or pickled.

    Nothing was done to it. The message says what to do instead.
    """


class MissingExtra(DucoError, ModuleNotFoundError):
    """A package is missing that only an extra installs. Nothing was started or sent.

    Attributes:
        extra: the extra that installs it: `pip install 'aioduco[…]'`.
    """

    def __init__(self, wanted: str, package: str, extra: str) -> None:
        hint = f"pip install 'aioduco[{extra}]'"
        if "ompl" in package and sys.version_info >= (3, 14):
            hint += " under Python 3.13: OMPL has no build for newer ones yet"
        super().__init__(f"{wanted} needs {package}: {hint}", name=package)
        self.extra: str = extra

    @classmethod
    @contextlib.contextmanager
    def named(cls, wanted: str, extra: str) -> Iterator[None]:
        """Name the extra, in a block of imports, if a package of it is missing.

        Args:
            wanted: what needs it.
            extra: the extra that installs it.
        """
        try:
            yield
        except ModuleNotFoundError as error:
            package = (error.name or "a package").partition(".")[0]
            if package == "aioduco" or isinstance(error, cls):
                raise
            raise cls(wanted, package, extra) from error


class _Described:
    """Stands in a pickled error for a value that pickle refuses: it looks the same when printed."""

    __slots__ = ("_text",)

    def __init__(self, text: str) -> None:
        self._text = text

    def __repr__(self) -> str:
        return self._text


def _text(value: object) -> str:
    """The `repr` of what was given, which may be anything: some have none, some a long one."""
    try:
        text = repr(value)
    except Exception as error:  # such as that of a number with more than 4300 digits
        return f"a {type(value).__name__} ({error})"
    if len(text) <= _LONGEST_VALUE:
        return text
    return f"{text[:_LONGEST_VALUE]}… ({len(text)} characters)"


def _restored(kind: type[_Error], arguments: tuple[Any, ...], fields: dict[str, Any]) -> _Error:
    error = kind.__new__(kind, *arguments)
    error.args = arguments
    error.__setstate__(fields)
    return error


def _pickleable(value: object) -> object:
    import pickle  # noqa: PLC0415 - rarely needed

    try:
        pickle.dumps(value)
    except Exception:
        return _Described(_text(value))
    return value


def _copied(value: object, memo: dict[int, Any]) -> object:
    try:
        return copy.deepcopy(value, memo)
    except Exception:
        return value
