"""Convert replies of the wire to samples of the state."""

from __future__ import annotations

import itertools
import math
import time
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Final

from aioduco._wire import newer, rpc
from aioduco.errors import StaleState
from aioduco.models.enums import OperationMode, ProgramState, RobotState, SafetyState
from aioduco.models.pose import Joints, Pose
from aioduco.models.state import (
    ForceStatus,
    IOStatus,
    JointTorques,
    RobotStates,
    RobotStatus,
    vectors,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


#: arrays of a status, and what the wire calls them
_ARRAYS: Final = {
    "joint_speeds": "jointActualVelocity",
    "joint_accelerations": "jointActualAccelera",
    "joint_currents": "jointActualCurrent",
    "joint_temperatures": "jointTemperature",
    "driver_temperatures": "driverTemperature",
    "tool_speed": "cartActualVelocity",
    "tool_acceleration": "cartActualAccelera",
    "expected_joint_speeds": "jointExpectVelocity",
    "expected_joint_accelerations": "jointExpectAccelera",
    "expected_tool_speed": "cartExpectVelocity",
    "expected_tool_acceleration": "cartExpectAccelera",
}


#: what the numbers of joints and poses are, for errors
_OF_JOINTS, _OF_POSES = "joint angles", "numbers of a pose"
#: joints and poses of a status: their class, what their numbers are, what the wire calls them
_SIXES: Final[dict[str, tuple[type[Joints | Pose], str, str]]] = {
    "joints": (Joints, _OF_JOINTS, "jointActualPosition"),
    "pose": (Pose, _OF_POSES, "cartActualPosition"),
    "expected_joints": (Joints, _OF_JOINTS, "jointExpectPosition"),
    "expected_pose": (Pose, _OF_POSES, "cartExpectPosition"),
}

#: of a status and of an I/O status, all at once
_status_lists: Final = attrgetter(*_ARRAYS.values())
_io_lists: Final = attrgetter(*rpc.IOStatus.__match_args__)


class Samples:
    """Makes samples of one robot, and numbers each kind of sample separately, from 0.

    The parameter `at` is the time of `time.monotonic()` at which the answer arrived; None: now.
    """

    def __init__(self) -> None:
        self._states = itertools.count()
        self._status = itertools.count()
        self._io = itertools.count()
        self._forces = itertools.count()

    def states(self, wire: Sequence[int], at: float | None = None) -> RobotStates:
        """Make a sample from the result of get_robot_state.

        Raises:
            StaleState: fewer than four states arrived: the controller is still starting.
        """
        at = time.monotonic() if at is None else at
        if len(wire) < 4:
            raise StaleState(
                f"the controller sent {len(wire)} of its 4 states: it is still starting; ask again"
            )
        robot, program, safety, mode = wire[:4]
        return RobotStates(
            sequence=next(self._states),
            received_at=at,
            robot=RobotState(robot),
            program=ProgramState(program),
            safety=SafetyState(safety),
            mode=OperationMode(mode),
        )

    def status(self, wire: rpc.RobotStatus, at: float | None = None) -> RobotStatus:
        """Make a sample from the result of getRobotStatus.

        Raises:
            StaleState: positions are missing: the controller is still starting.
        """
        at = time.monotonic() if at is None else at
        for _, what, name in _SIXES.values():
            _six(getattr(wire, name), what)
        return RobotStatus.of(next(self._status), at, partial(_status_values, wire))

    def forces(
        self, tool: Sequence[float], external: Sequence[float], at: float | None = None
    ) -> ForceStatus:
        """Make a sample from the results of get_tcp_force and get_ext_torque."""
        at = time.monotonic() if at is None else at
        tool_, external_ = vectors(tool, external)
        return ForceStatus(next(self._forces), at, tool_, external_)

    def io(self, read: Callable[[], rpc.IOStatus], at: float | None = None) -> IOStatus:
        """Make a sample from the result of getRobotIOStatus, whose lists are in the same order.

        Args:
            read: returns the result; called when the first value of the sample is used.
            at: when its answer arrived.
        """
        at = time.monotonic() if at is None else at
        return IOStatus.of(next(self._io), at, lambda _: _io_values(read()))


def _io_values(wire: rpc.IOStatus) -> dict[str, object]:
    """All values of an I/O status."""
    return dict(zip(IOStatus.__match_args__[2:], map(tuple, _io_lists(wire)), strict=True))


def _status_values(wire: rpc.RobotStatus, name: str) -> dict[str, object]:
    """One value of a status; of its arrays all, and of its other values all: they cost little."""
    if name in _SIXES:
        kind, _, wired = _SIXES[name]
        return {name: kind(*getattr(wire, wired)[:6])}
    if name in _ARRAYS:
        return dict(zip(_ARRAYS, vectors(*_status_lists(wire)), strict=True))
    return {
        "enabled": tuple(wire.slaveReady),
        "collision": wire.collision,
        "collision_axis": wire.collisionAxis,
        "emergency_stop": wire.emcStopSignal,
        "state": RobotState(wire.robotState),
        "error": wire.robotError,
        "torques": _torques(wire) if isinstance(wire, newer.RobotStatus) else None,
    }


def _torques(wire: newer.RobotStatus) -> JointTorques:
    """What a controller of manual 4.3 adds."""
    lists = (
        wire.jointAuxiliaryPosition,
        wire.jointDynamicTorque,
        wire.jointGravityTorque,
        wire.jointActualTorque,
        wire.jointExtraTorque,
    )
    return JointTorques(*vectors(*(values or () for values in lists)))


def joints(wire: Sequence[float]) -> Joints:
    """Convert joint angles of the wire; external axes after the sixth are left out.

    Raises:
        StaleState: there are fewer than six, or some are not finite: the controller is starting.
    """
    return Joints(*_six(wire, _OF_JOINTS))


def pose(wire: Sequence[float]) -> Pose:
    """Convert a pose of the wire.

    Raises:
        StaleState: there are fewer than six numbers, or some are not finite: the controller is
            still starting.
    """
    return Pose(*_six(wire, _OF_POSES))


def _six(wire: Sequence[float], what: str) -> Sequence[float]:
    six = some(wire, 6, what)
    if not all(map(math.isfinite, six)):
        raise StaleState(
            f"the controller sent {list(six)}, which is not finite: it is still starting, or at "
            "fault; ask again"
        )
    return six


def some(wire: Sequence[float], count: int, what: str) -> Sequence[float]:
    """Return so many numbers of the wire; `what` they are is for the error.

    Raises:
        StaleState: there are fewer: the controller is still starting.
    """
    if len(wire) < count:
        raise StaleState(
            f"the controller sent {len(wire)} of {count} {what}: it is still starting; ask again"
        )
    return wire[:count]
