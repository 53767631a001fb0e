"""Errors: each says what was wrong, what was or was not done to the arm, and what to do."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = [
    "BusError",
    "CalibrationError",
    "CallTimeout",
    "CameraError",
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
    "LaneFailed",
    "MissingExtra",
    "ModbusError",
    "ModbusGarbled",
    "ModbusRefused",
    "ModbusTimeout",
    "MotionCarriedOut",
    "NamedElsewhere",
    "NoPathFound",
    "NotAController",
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
    "WrongLoop",
    "WrongProcess",
]


class DucoError(Exception):
    """Base of all errors of this package."""


class ParameterError(DucoError, ValueError):
    """An argument is outside what the manual allows. Nothing was sent.

    Attributes:
        parameter: the name of the parameter.
        value: what was given.
        expected: what is allowed, with the unit.
    """

    def __init__(self, parameter: str, value: object, expected: str) -> None:
        self.parameter = parameter
        self.value = value
        self.expected = expected
        super().__init__(f"{parameter} is {value!r}, but must be {expected}; nothing was sent")


class MotionCarriedOut(DucoError, TypeError):
    """What was to be a motion is how one ended: **the arm has moved** before this was called.

    Of what was given with it, nothing was sent.

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
    """A function of the manual was asked of an object that does not have it; nothing was sent.

    Attributes:
        function: what was asked for.
        meant: where it is.
    """

    def __init__(self, function: str, meant: str) -> None:
        self.function = function
        self.meant = meant
        super().__init__(f"{function} is {meant}")

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.function, self.meant)


class ConnectError(DucoError, ConnectionError):
    """No connection to a controller could be made. Nothing was sent.

    Attributes:
        host: address that was tried.
        port: TCP port that was tried.
    """

    def __init__(self, host: str, port: int, reason: str) -> None:
        self.host = host
        self.port = port
        super().__init__(f"cannot connect to {host}:{port}: {reason}")


class ConnectTimeout(ConnectError, TimeoutError):
    """Something accepted the connection, but answered no call in time."""


class NotAController(ConnectError):
    """What listens there does not speak the controller's protocol."""


class ConnectionLost(DucoError, ConnectionError):
    """The connection broke, or was closed, before or during a call.

    For a function that only reads, nothing happened and it may be called again. A command
    whose reply was lost raises `OutcomeUnknown` instead.
    """


class CallTimeout(ConnectionLost, TimeoutError):
    """A function that only reads was not answered within its deadline.

    The connection was closed, so that the late answer can reach nobody.
    """


class NotSent(ConnectionLost, TimeoutError):
    """The time for a call was over before anything of it could be sent. Nothing happened.

    Every connection of its lane was taken, or a new one could not be made in time.
    """


class OutcomeUnknown(ConnectionLost):
    """A command was sent, but its reply never came: it may or may not have been carried out.

    It is never sent again by itself. Look at the robot's state before you decide.

    Attributes:
        function: the function of the wire that was called.
    """

    def __init__(self, function: str, reason: str) -> None:
        self.function = function
        super().__init__(
            f"{function} was sent, but {reason}: it may or may not have been carried out; "
            "it was not sent again. Read the robot's state before you repeat it"
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
        """The same error, of a controller whose version is known."""
        return UnknownFunction(self.function, self._message, self.code, version=version)


class Refused(DucoError):
    """The controller refused a call by its return value.

    Attributes:
        function: the function of the wire that was called.
        code: the value that it returned: a number, or what stands for nothing where something is
            read, such as an empty text.
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
    """A device on RS-485 did not do what a Modbus request asked for, or it is not known."""


class ModbusRefused(ModbusError):
    """The device answered a request with a Modbus exception: it did not do it.

    Attributes:
        function: the Modbus function that was asked for.
        code: the exception's code.
    """

    def __init__(self, function: int, code: int, meaning: str) -> None:
        self.function = function
        self.code = code
        super().__init__(
            f"the device refused Modbus function {function:#04x}: exception {code}, {meaning}"
        )


class ModbusTimeout(ModbusError, TimeoutError):
    """The device did not answer in time. If it was to write, it may or may not have done so.

    Look at wiring, bit rate and the number of the device. Nothing is sent again by itself.
    """


class ModbusGarbled(ModbusError):
    """What came over the bus is no answer to the request: a wrong checksum, or another's bytes.

    If the device was to write, it may or may not have done so. Nothing is sent again by itself.
    """


class GripperError(DucoError):
    """A gripper did not do what it was asked for: one of the subclasses, mostly."""


class GripperNotActivated(GripperError):
    """The gripper has to be activated after power on before it moves; nothing moved.

    `await gripper.activate()` does it. The fingers may go through all of their stroke then.
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
    """The gripper did not come to rest in time, or its sensor did not answer the output."""


class ObjectLost(GripperError):
    """The gripper does not hold what it gripped, or has gripped nothing."""


class TrackPoolFull(Refused):
    """The track pool has no room for the points.

    The manual does not say whether those that had room were put in: `getQueueSize` tells how many
    it holds. Wait until the arm has taken some, or empty it (`trackClearQueue`).
    """

    def __init__(self, function: str, code: int) -> None:
        super().__init__(function, code, "the track pool, of 1000 points, has no room for them")


class RobotStateError(DucoError):
    """The robot is not in a state in which this can be done."""


class PersonNeeded(RobotStateError):
    """Only a person can lead the robot out of its state; the message says what to do."""


class WrongLoop(RobotStateError):
    """The robot is used outside of the event loop on which it was opened. Nothing was sent.

    The robot goes on undisturbed on its own loop.
    """


class WrongProcess(RobotStateError):
    """The robot is used in a child that was forked from the process that opened it.

    Nothing was sent. The robot goes on undisturbed in the parent.
    """


class GuardLost(DucoError):
    """The guard's process could not be started, or is gone. The arm is stopped by other ways."""


class HeartbeatLost(RobotStateError):
    """The heartbeat is not beating, so no motion may be started."""


class StopUnconfirmed(DucoError):
    """A stop was asked for, but it is not known that the arm stands.

    The one error that calls for a hand on the emergency stop.
    """


class StopsUnconfirmed(StopUnconfirmed):
    """Several arms were told to stop, and of some it is not known that they stand.

    Attributes:
        errors: for each robot, in the order in which they were given, why that is not known; None
            for one that stands.
    """

    def __init__(self, message: str, errors: tuple[DucoError | None, ...]) -> None:
        super().__init__(message)
        self.errors = errors

    @classmethod
    def of(cls, places: Sequence[str], errors: Sequence[DucoError | None]) -> StopsUnconfirmed:
        """Make one of what is known of each robot, and of where they are."""
        pairs = zip(places, errors, strict=True)
        said = [f"{place}: {error}" for place, error in pairs if error is not None]
        return cls(
            f"of {len(said)} of {len(places)} arms it is not known that they stand: "
            + "; ".join(said),
            tuple(errors),
        )


class FeedOverflow(DucoError):
    """A subscriber that is to have every item did not take them in time: some are missing."""


class StaleState(DucoError):
    """The newest sample of the robot's state is older than allowed."""


class TaskError(DucoError):
    """A task did not finish.

    Attributes:
        task_id: the controller's id of the task; None if it never told one.
        name: the function that started it.
        errors: the controller's error list when the task ended.
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
    """The task was lost sight of: it may have ended, or may be running."""


class TaskInterrupted(TaskError):
    """The task was interrupted before its end, other than by blending into the next one."""


class TaskFailed(TaskError):
    """The controller ended the task with an error."""


class TaskIllegal(TaskError):
    """The task is not allowed in the robot's state: not enabled, stopped, unknown tool, …"""


class TaskParameterMismatch(TaskError):
    """The controller found a parameter of the task wrong."""


class Unreachable(DucoError):
    """No configuration of the arm reaches a pose, by the kinematics that was asked.

    That of this computer, or the controller's (`cal_ikine`). Nothing was moved.
    """


class EnvelopeViolated(DucoError):
    """A motion would lead beyond a limit of `robot.envelope`. It was not sent.

    Attributes:
        limit: the name of the limit.
        body: what would be beyond it: "tool", "elbow", "flange", a joint, or the arm.
        place: where in the base frame [m]; NaN where a place says nothing.
        margin: how far within the limit it would be, negative beyond it [m, rad, m/s, N], or
            without a unit for a singularity.
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

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (str(self), self.limit, self.body, self.place, self.margin)


class PlanningError(DucoError):
    """No plan was made. Nothing was sent, and nothing moved.

    Attributes:
        pair: names of the two bodies that are in the way of each other; None if it is not that.
        joints: the configuration that it is about [rad]; None if it is about none.
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
    """Start and goal are free, but no way from one to the other was found in the time given.

    That there is none is not shown by it.
    """


class PathIncomplete(PlanningError):
    """A line or an arc of the tool is free and within reach for a part of its way only.

    Attributes:
        fraction: how much of the way that is, 0 to 1.
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
    """The arm would touch something on its planned way, in the scene as it is now.

    Raised while a plan is carried out, the arm was brought to rest on its way before.
    """


class SetPointTooFar(ParameterError):
    """A set-point lies further from the one before than a stream allows. It was not sent.

    The stream goes on: the arm stays at the set-point before.
    """


class StreamError(DucoError):
    """A stream ended other than by its program closing it.

    Attributes:
        statistics: the stream's statistics at its end; None if it never began.
    """

    def __init__(self, message: str, statistics: object = None) -> None:
        self.statistics = statistics
        super().__init__(message)


class StreamClosed(StreamError):
    """The stream was closed, and takes no set-points any more."""


class StreamStarved(StreamError):
    """The program sent no set-point in time. The arm was brought to rest, and stopped."""


class StreamStopped(StreamError):
    """The robot was stopped while the stream ran. The stream sends nothing any more."""


class StreamRefused(StreamError):
    """The controller refused a set-point, or left the state in which it follows them."""


class StreamLost(StreamError, ConnectionLost):
    """The stream's connection broke, or was not answered in time. A stop was tried."""


class FirstPointTooFar(StreamError):
    """The first set-point was too far from where the arm was. Nothing was sent."""


class LaneFailed(StreamError):
    """The stream's lane ended by an error of its own, or its process was killed."""


class PathToleranceViolated(StreamError):
    """The arm strayed from its trajectory. It was brought to rest, and stopped."""


class GoalToleranceViolated(StreamError):
    """The arm did not come close enough to the end of its trajectory in time. It stands."""


class StreamLeavesEnvelope(StreamError, EnvelopeViolated):
    """A set-point would lead beyond a limit of `robot.envelope`, or the arm could not stop before.

    It was not sent. The arm was brought to rest before the limit, and stopped.
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
    """A number that reads like another unit than the one it is taken for; it was taken as it is.

    Python shows it once for each line of a program.
    """


class RenderError(DucoError, RuntimeError):
    """This computer can draw no picture of a simulator, or show no window. It goes on without."""


class CameraError(DucoError, OSError):
    """A camera gives no picture: it is not there, or was unplugged. Nothing was done to the arm."""


class CalibrationError(DucoError, ValueError):
    """From these views it cannot be told where a camera is: it says what is wrong with them."""


class RecordingError(DucoError):
    """A recording cannot be written, read or played. What it says was done to the arm, was done."""


class PathRefused(DucoError):
    """Something speaks against leading the arm along a recorded path or to waypoints.

    Nothing was sent.

    Attributes:
        findings: what, each with its place.
    """

    def __init__(self, message: str, findings: tuple[str, ...]) -> None:
        self.findings = findings
        super().__init__(message)

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (str(self), self.findings)


class WaypointFileError(DucoError, ValueError):
    """A file of waypoints cannot be read or written: it says the line and the field.

    Nothing was sent.
    """


class MissingExtra(DucoError, ModuleNotFoundError):
    """A package is not installed that only an extra brings. Nothing was started or sent.

    Attributes:
        extra: the extra that brings it: `pip install 'aioduco[…]'`.
    """

    def __init__(self, wanted: str, package: str, extra: str) -> None:
        super().__init__(f"{wanted} needs {package}: pip install 'aioduco[{extra}]'", name=package)
        self.extra: str = extra

    def __reduce__(self) -> tuple[object, ...]:
        wanted = str(self).partition(" needs ")[0]
        return type(self), (wanted, self.name, self.extra)
