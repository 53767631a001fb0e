"""What goes into a twin and comes out of it: samples, commands, divergences. Plain values."""

from __future__ import annotations

import math
from enum import Enum
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from aioduco._process import trial

if TYPE_CHECKING:
    from collections.abc import Mapping

    from aioduco.models.state import ForceStatus, RobotStates, RobotStatus

#: six numbers, one for each joint or each direction
Six: TypeAlias = tuple[float, ...]


class Quantity(Enum):
    """What differs between the arm and its twin.

    Attributes:
        TORQUE: the external torques of the joints, or the force at the tool.
        TRACKING: the distance of the joints from their set-points.
        GEOMETRY: the pose of the tool for its joints.
        PATH: the path of the set-points.
        DELAY: the time at which the set-points come.
        STATE: the states of the controller.
        OUTCOME: the answer to a command.
    """

    TORQUE = "torque"
    TRACKING = "tracking error"
    GEOMETRY = "geometry"
    PATH = "path"
    DELAY = "delay"
    STATE = "state"
    OUTCOME = "outcome"


class Cause(Enum):
    """The probable cause of a divergence, by the pattern of what differs.

    Attributes:
        PAYLOAD: the flange carries more than was set.
        LOST_PART: the flange carries less than was set.
        FRICTION: the joints' friction has changed.
        CONTACT: something pushes at the arm.
        GEOMETRY: the arm has other lengths or another tool.
        OTHER_PROGRAM: another client, or a person, commands the arm.
        DELAYED_CONTROLLER: the controller carries commands out later or more slowly.
        UNKNOWN: none of these explains it.
    """

    PAYLOAD = "payload"
    LOST_PART = "lost part"
    FRICTION = "friction"
    CONTACT = "contact"
    GEOMETRY = "geometry"
    OTHER_PROGRAM = "another program"
    DELAYED_CONTROLLER = "delayed controller"
    UNKNOWN = "unknown"


class TwinSample(NamedTuple):
    """One sample of the arm's state.

    Attributes:
        time: when it was received [s].
        joints, speeds: actual joint angles and speeds [rad, rad/s].
        expected, expected_speeds: set-points of the drives [rad, rad/s].
        pose: pose of the tool [m, rad]; None if it was not read with this sample.
        external: observed external torques [N m]; None if the controller does not report them.
        force: force and torque at the tool, along the base's axes [N, N m]; None without a sensor.
        robot, program, safety: states of the controller, as numbers.
        collision: joint that detected a collision, 1 to 6, or 0.
        led: whether a stream, a mode or a blocking call leads the arm, so that its commands are not
            known.
    """

    time: float
    joints: Six
    speeds: Six
    expected: Six
    expected_speeds: Six
    pose: Six | None
    external: Six | None
    force: Six | None
    robot: int
    program: int
    safety: int
    collision: int
    led: bool = False

    @property
    def whole(self) -> bool:
        """Whether all numbers are finite: torques and forces may be unknown, but not infinite."""
        numbers = (
            *(self.joints, self.speeds, self.expected, self.expected_speeds),
            *(self.pose or (), self.external or (), self.force or ()),
        )
        return all(math.isfinite(number) for part in numbers for number in part)

    @classmethod
    def of(
        cls,
        states: RobotStates,
        status: RobotStatus,
        forces: ForceStatus | None,
        *,
        led: bool = False,
    ) -> TwinSample:
        """Make a sample from parts of one sample of a robot's feed."""
        external = force = None
        if forces is not None:
            external = _known(tuple(forces.external_torques.tolist()))
            force = _known(tuple(forces.tool.tolist()))
        return cls(
            trial.wall(status.received_at),
            tuple(status.joints),
            tuple(status.joint_speeds.tolist()),
            tuple(status.expected_joints),
            tuple(status.expected_joint_speeds.tolist()),
            tuple(status.pose),
            external,
            force,
            int(states.robot),
            int(states.program),
            int(states.safety),
            status.collision_axis if status.collision else 0,
            led,
        )


def _known(values: Six) -> Six | None:
    """The numbers; None if the controller did not send one of them."""
    return values if all(value == value for value in values) else None  # noqa: PLR0124 - NaN


class TwinCommand(NamedTuple):
    """A call of the program that has ended.

    Attributes:
        time: the middle of the call [s].
        function: the function of the wire.
        arguments: its arguments, in the order of the wire.
        accepted: whether the controller accepted it; None if it is not known, or it was not sent.
    """

    time: float
    function: str
    arguments: tuple[Any, ...]
    accepted: bool | None

    @classmethod
    def of(
        cls, time: float, function: str, arguments: tuple[Any, ...], error: str, answer: Any
    ) -> TwinCommand:
        """Make a command from its call: the class of its error, empty for none, and its answer."""
        accepted: bool | None = not (type(answer) is int and answer < 0)
        if error:
            accepted = False if error in ("ControllerError", "UnknownFunction") else None
        return cls(time, function, arguments, accepted)


class Divergence(NamedTuple):
    """The arm and its twin have parted.

    Attributes:
        quantity: what differs.
        where: where: "joint 3", "tool", or the state or command that differs.
        at: when it was detected [s].
        since: when it began, as far as that is known [s].
        value, limit: the size of the difference, and the limit that it exceeds, in `unit`.
        unit: their unit; empty for states and outcomes.
        cause: the probable cause.
        estimate: what the cause would be, in its own unit, such as {"mass": 0.48}; may be empty.
    """

    quantity: Quantity
    where: str
    at: float
    since: float
    value: float
    limit: float
    unit: str
    cause: Cause
    estimate: Mapping[str, float]

    def __str__(self) -> str:
        amount = f" {self.value:.3g} {self.unit}, limit {self.limit:.3g}" if self.unit else ""
        found = ", ".join(f"{name} {value:.3g}" for name, value in self.estimate.items())
        return (
            f"{self.quantity.value} at {self.where}:{amount}; probable cause: {self.cause.value}"
            f"{f' ({found})' if found else ''}"
        )
