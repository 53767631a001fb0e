"""Recordings as a twin's input: limits are learned from a good run, and any run is judged."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco._wire.rpc import Op
from aioduco.errors import ParameterError, RecordingError
from aioduco.kinematics import arm as arm_of
from aioduco.kinematics.catalogue import model_named
from aioduco.kinematics.mounting import base_in_world
from aioduco.models.enums import ProgramState, RobotState, SafetyState
from aioduco.models.pose import Pose
from aioduco.models.rotation import matrix_from_quaternion, rpy_from_matrix
from aioduco.recording.run import RecordedMessage, RecordedRun, of_any_maker, read
from aioduco.sim.twin import limits as limits_of
from aioduco.sim.twin.data import Divergence, Six, TwinCommand, TwinSample
from aioduco.sim.twin.limits import TwinLimits, deviations
from aioduco.sim.twin.monitor import TwinMonitor
from aioduco.sim.twin.predictor import AHEAD

if TYPE_CHECKING:
    import os
    from collections.abc import Iterator, Sequence

    from aioduco.kinematics import Arm
    from aioduco.kinematics.mounting import MountingLike


#: channels with parts of samples
_PARTS = (
    *("/joint_states", "/joint_setpoints", "/tf", "/state", "/wrench", "/stream_setpoints"),
    "/commands",
)
#: the function that ends each mode in which the arm's commands are not known
_MODES = {
    "teach_mode": "end_teach_mode",
    "fc_start": "fc_stop",
    "start_realtime_mode": "end_realtime_mode",
}
_OPS = {field.name for field in dataclasses.fields(Op)}


@of_any_maker
def learn(
    path: str | os.PathLike[str], *, arm: str | None = None, mounting: MountingLike | None = None
) -> TwinLimits:
    """Learn the limits of a twin from the recording of a good run.

    In this run everything should be as it will be later: tool, payload, speeds, the same or similar
    motions by all joints, for a minute or more. A limit is a third above the largest difference of
    that run, and a fixed amount; what the run does not show has the wide limit of `TwinLimits.of`.

    Args:
        path: the recording, with forces; `robot.record` and `aioduco record` make it.
        arm: the arm; None for the one that the recording names.
        mounting: "floor", "wall" or "ceiling", as of a simulator, or pose of the base in the world
            [m, rad]; None for on the floor.

    Raises:
        ParameterError: the arm is not known, or it moved for less than five seconds.
        RecordingError: the file is no recording, or has no samples of the state.
    """
    run = read(path)
    chosen = _arm(run, arm)
    base = None if mounting is None else base_in_world(mounting, chosen)
    return limits_of.learn(chosen, deviations(chosen, items(run), mounting=base))


@of_any_maker
def judge(
    path: str | os.PathLike[str],
    limits: TwinLimits | None = None,
    *,
    arm: str | None = None,
    mounting: MountingLike | None = None,
) -> list[Divergence]:
    """Say where the arm of a recording and its twin parted. Times count from its beginning.

    Args:
        path: the recording.
        limits: the limits; None for wide ones.
        arm: the arm; None for the one that the recording names.
        mounting: "floor", "wall" or "ceiling", as of a simulator, or pose of the base in the world
            [m, rad]; None for on the floor.

    Raises:
        ParameterError: the arm is not known.
        RecordingError: the file is no recording, or has no samples of the state.
    """
    run = read(path)
    chosen = _arm(run, arm)
    known = TwinLimits.of(chosen) if limits is None else limits
    base = None if mounting is None else base_in_world(mounting, chosen)
    told = run.topics.get("/commands", 0) > 0
    monitor, found = TwinMonitor(chosen, known, mounting=base, commands=told), []
    for item in items(run):
        if isinstance(item, TwinCommand):
            monitor.command(item)
        else:
            found += monitor.sample(item)
    return found


def _arm(run: RecordedRun, name: str | None) -> Arm:
    if name is not None:
        return arm_of(name)
    told = run.metadata.get("arm", "")
    if (found := model_named(told)) is None:
        raise ParameterError("arm", told, "a known arm: the recording names none, so give it")
    return found


def items(run: RecordedRun) -> Sequence[TwinSample | TwinCommand]:
    """The samples and commands of a recording, in the order in which a twin takes them."""
    found: list[TwinSample | TwinCommand] = [*_samples(run)]
    if not found:
        raise RecordingError(f"{run.path} has no samples of the state: `aioduco record` takes them")
    found += _tool(run)
    found += _commands(run)
    found.sort(key=lambda item: item.time - (AHEAD if isinstance(item, TwinCommand) else 0.0))
    return found


def _tool(run: RecordedRun) -> Iterator[TwinCommand]:
    """The tool at the begin, which was set before the recording."""
    for message in run.messages("/tf"):
        if "flange" in message.data:
            tip = Pose(*_pose(message.data["flange"])).inverse()
            arguments: tuple[Any, ...] = ("recorded", list(tip), [0.0] * 4, [])
            yield TwinCommand(-math.inf, "set_tool_data", arguments, True)
            return


def _commands(run: RecordedRun) -> Iterator[TwinCommand]:
    for message in run.messages("/commands"):
        data = message.data
        arguments = tuple(
            Op(**each) if isinstance(each, dict) and each.keys() <= _OPS else each
            for each in data["arguments"]
        )
        # a blocking call lasts as long as its motion
        lasts = 0.0 if data["lane"] == "blocking" else float(data["duration"])
        at = message.time + 0.5 * lasts
        error = data["error"].partition(":")[0]
        yield TwinCommand.of(at, data["function"], arguments, error, data["result"])


def _samples(run: RecordedRun) -> Iterator[TwinSample]:
    setpoint: RecordedMessage | None = None
    pose: tuple[float, Six] | None = None
    state: dict[str, Any] = {}
    wrench: dict[str, Any] = {}
    streaming = -math.inf
    #: the functions that end the modes that are on
    modes: set[str] = set()
    pending: RecordedMessage | None = None
    for message in run.messages(*_PARTS):
        data = message.data
        if message.topic == "/joint_states":
            # the other channels of a sample come after it, with about the same time
            if pending is not None and setpoint is not None and state:
                led = pending.time - streaming < 1.0 or bool(modes)
                yield _sample(pending, setpoint, pose, state, wrench, led=led)
            pending = message
        elif message.topic == "/joint_setpoints":
            setpoint = message
        elif message.topic == "/tf" and "tcp" in data:
            pose = message.time, _pose(data["tcp"])
        elif message.topic == "/state":
            state = data
        elif message.topic == "/wrench":
            wrench = data
        elif message.topic == "/stream_setpoints":
            streaming = message.time
        elif message.topic == "/commands" and not data["error"]:
            modes.discard(data["function"])
            if data["function"] in _MODES:
                modes.add(_MODES[data["function"]])


def _sample(
    joints: RecordedMessage,
    setpoint: RecordedMessage,
    pose: tuple[float, Six] | None,
    state: dict[str, Any],
    wrench: dict[str, Any],
    *,
    led: bool,
) -> TwinSample:
    fresh = pose is not None and abs(pose[0] - joints.time) < 1e-3
    external = wrench.get("external_torques")
    force = [wrench.get(each, {}).get(axis) for each in ("force", "torque") for axis in "xyz"]
    return TwinSample(
        joints.time,
        tuple(joints.data["position"]),
        _speeds(joints),
        tuple(setpoint.data["position"]),
        _speeds(setpoint),
        pose[1] if fresh and pose is not None else None,
        None if external is None or None in external else tuple(external),
        None if None in force else tuple(force),
        int(RobotState.__members__.get(state["robot"], RobotState.DISABLE)),
        int(ProgramState.__members__.get(state["program"], ProgramState.STOPPED)),
        int(SafetyState.__members__.get(state["safety"], SafetyState.RUN)),
        int(state["collision_axis"]) if state["collision"] else 0,
        led,
    )


def _speeds(message: RecordedMessage) -> Six:
    return tuple(each or 0.0 for each in message.data.get("velocity", (0.0,) * 6))


def _pose(transform: dict[str, Any]) -> Six:
    x, y, z, w = transform["rotation"]
    return (
        *transform["translation"],
        *rpy_from_matrix(matrix_from_quaternion(np.array([w, x, y, z]))),
    )
