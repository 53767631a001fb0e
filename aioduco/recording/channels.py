"""As what messages a robot is recorded: the channels of a file, their schemas and units.

Foxglove's schemas are used where there is one; the other channels are JSON with a schema. Numbers
that are measured at each sample are rounded to a grid finer than what the arm's sensors tell, since
digits of noise are most of the size of a file: see `ANGLE`, `SPEED` and so on. A channel whose
values change seldom is written when they do, and once a second.
"""

from __future__ import annotations

import dataclasses
import enum
import json
import math
from typing import TYPE_CHECKING, Any, Final, Protocol

import foxglove
from foxglove.channels import FrameTransformsChannel, JointStatesChannel, LogChannel
from foxglove.mcap import MCAPCompression, MCAPWriteOptions
from foxglove.messages import (
    FrameTransform,
    FrameTransforms,
    JointState,
    JointStates,
    Log,
    LogLevel,
    Quaternion,
    Timestamp,
    Vector3,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from foxglove import JsonSchema  # type: ignore[attr-defined]

    from aioduco.models.pose import Pose
    from aioduco.supervision.events import Event
    from aioduco.supervision.state_feed import Snapshot

__all__ = ["ANGLE", "FORCE", "LENGTH", "QUATERNION", "SPEED", "MessageChannels", "plain"]

# Powers of two: so the rest of each number is zeros, which the file is compressed by.
#: steps of recorded angles: 1 µrad
ANGLE: Final = 2.0**20
#: steps of recorded speeds of joints: 61 µrad/s
SPEED: Final = 2.0**14
#: steps of recorded positions: 0.95 µm
LENGTH: Final = 2.0**20
#: steps of the four numbers of a recorded rotation
QUATERNION: Final = 2.0**20
#: digits of recorded forces: 1 mN, 1 mN·m
FORCE: Final = 3
#: digits of recorded currents, temperatures and analogue signals
_ROUGH: Final = 2
#: seconds after which a channel is written although nothing changed
_AGAIN: Final = 1.0
#: seconds between two messages about the drives
_DRIVES_EVERY: Final = 0.1

_NAMES: Final = tuple(f"joint_{number}" for number in range(1, 7))
_LEVELS: Final = (
    (50, LogLevel.Fatal),
    (40, LogLevel.Error),
    (30, LogLevel.Warning),
    (20, LogLevel.Info),
    (0, LogLevel.Debug),
)

_NUMBER: Final = {"type": "number"}
_NUMBERS: Final = {"type": "array", "items": {"type": "number"}}
_FLAG: Final = {"type": "boolean"}
_FLAGS: Final = {"type": "array", "items": {"type": "boolean"}}
_TEXT: Final = {"type": "string"}
_TEXTS: Final = {"type": "array", "items": {"type": "string"}}
_ANY: Final[dict[str, Any]] = {}
_XYZ: Final = {"type": "object", "properties": {"x": _NUMBER, "y": _NUMBER, "z": _NUMBER}}

#: by channel in JSON, its fields
_FIELDS: Final[dict[str, dict[str, Any]]] = {
    "/wrench": {"force": _XYZ, "torque": _XYZ, "external_torques": _NUMBERS},
    "/drives": {"currents": _NUMBERS, "temperatures": _NUMBERS, "driver_temperatures": _NUMBERS},
    "/io": {
        **dict.fromkeys(
            ("digital_inputs", "digital_outputs", "tool_inputs", "tool_outputs", "tool_buttons"),
            _FLAGS,
        ),
        **dict.fromkeys(
            (
                *("analog_current_inputs", "analog_current_outputs"),
                *("analog_voltage_inputs", "analog_voltage_outputs"),
            ),
            _NUMBERS,
        ),
    },
    "/registers": {
        **dict.fromkeys(
            ("bool_inputs", "bool_outputs", "function_inputs", "function_outputs"), _FLAGS
        ),
        **dict.fromkeys(("word_inputs", "word_outputs", "float_inputs", "float_outputs"), _NUMBERS),
    },
    "/state": {
        **dict.fromkeys(("robot", "program", "safety", "mode"), _TEXT),
        "enabled": _FLAGS,
        "collision": _FLAG,
        "collision_axis": _NUMBER,
        "emergency_stop": _FLAG,
        "error": _NUMBER,
    },
    "/commands": {
        "function": _TEXT,
        "arguments": {"type": "array", "items": _ANY},
        "result": _ANY,
        "error": _TEXT,
        "duration": _NUMBER,
        "lane": _TEXT,
    },
    "/tasks": {
        "id": _NUMBER,
        "name": _TEXT,
        "state": _TEXT,
        "outcome": _TEXT,
        "done": _FLAG,
        "motion": _FLAG,
        "duration": _NUMBER,
        "errors": _TEXTS,
    },
    "/events": {"event": _TEXT, "what": _ANY},
    "/streams": {
        **dict.fromkeys(("stream", "state", "reason"), _TEXT),
        **dict.fromkeys(
            ("rate", "ticks", "sent", "missed", "starved", "limited", "overwritten"), _NUMBER
        ),
        **{
            name: {
                "type": "object",
                "properties": dict.fromkeys(("samples", "p50", "p99", "p999", "max"), _NUMBER),
            }
            for name in ("lateness", "interval", "round_trip", "age")
        },
    },
    "/stream_setpoints": {"stream": _TEXT, "taken": _NUMBER, "point": _NUMBERS},
}


class Writable(Protocol):
    """What a file is written to."""

    def write(self, data: bytes | bytearray) -> int:
        """Write some bytes."""
        ...

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go to a position."""
        ...

    def flush(self) -> None:
        """Pass on what is kept."""
        ...


class _ChannelSet:
    """The channels of one file. The library keeps them for ever: they are used again."""

    def __init__(self) -> None:
        self.context = foxglove.Context()
        self.joints = JointStatesChannel("/joint_states", context=self.context)
        self.setpoints = JointStatesChannel("/joint_setpoints", context=self.context)
        self.transforms = FrameTransformsChannel("/tf", context=self.context)
        self.log = LogChannel("/log", context=self.context)
        self.json = {
            topic: foxglove.Channel(
                topic, schema=_schema(topic, fields), message_encoding="json", context=self.context
            )
            for topic, fields in _FIELDS.items()
        }


def _schema(topic: str, fields: dict[str, Any]) -> JsonSchema:
    return {"type": "object", "title": f"aioduco.{topic[1:]}", "properties": fields}


#: sets that no file uses now
_free: list[_ChannelSet] = []


class MessageChannels:
    """Writes messages about a robot; on one thread.

    Times are seconds of `time.monotonic()`; the file has nanoseconds since 1970, by the difference
    of the two clocks at the beginning.

    Args:
        target: what the file is written to.
        metadata: what the file says about the recording; `clock_offset` is the difference of the
            clocks [ns].
    """

    def __init__(self, target: Writable, metadata: dict[str, str]) -> None:
        self._set = _free.pop() if _free else _ChannelSet()
        self._offset = int(metadata["clock_offset"]) // 1000
        # one thread, for a robot's program has better use for the others
        options = MCAPWriteOptions(
            profile="aioduco",
            chunk_size=None,
            compression=MCAPCompression.Zstd,
            compression_threads=0,
            disable_seeking=True,
        )
        self._writer = foxglove.open_mcap(target, context=self._set.context, writer_options=options)
        self._closed = False
        self._flange: FrameTransform | None = None
        self._pose: tuple[float, ...] | None = None
        self._last: dict[str, tuple[float, Any]] = {}
        self.metadata("aioduco", metadata)

    def metadata(self, name: str, values: dict[str, str]) -> None:
        """Write texts about the recording itself."""
        self._writer.write_metadata(name, values)

    def flush(self) -> None:
        """End the chunk."""
        self._writer.flush()

    def close(self) -> None:
        """End the file."""
        if not self._closed:
            self._closed = True
            try:
                self._writer.close()
            finally:
                _free.append(self._set)

    # -- what is recorded ------------------------------------------------------------------------

    def sample(self, sample: Snapshot) -> None:
        """Write a sample of the state."""
        status, states, io = sample.status, sample.states, sample.io
        at = status.received_at
        stamp, time_ns = self._times(at)
        self._joints(self._set.joints, stamp, time_ns, status.joints, status.joint_speeds.tolist())
        self._joints(
            self._set.setpoints,
            stamp,
            time_ns,
            status.expected_joints,
            status.expected_joint_speeds.tolist(),
        )
        self._transforms(at, stamp, time_ns, status.pose)
        state = {
            "robot": states.robot.name,
            "program": states.program.name,
            "safety": states.safety.name,
            "mode": states.mode.name,
            "enabled": status.enabled,
            "collision": status.collision,
            "collision_axis": status.collision_axis,
            "emergency_stop": status.emergency_stop,
            "error": status.error,
        }
        self._if_changed("/state", at, state)
        self._if_changed("/io", at, _fields("/io", io))
        self._if_changed("/registers", at, _fields("/registers", io))
        if self._due("/drives", at, _DRIVES_EVERY):
            drives = {
                "currents": _rounded(status.joint_currents.tolist()),
                "temperatures": _rounded(status.joint_temperatures.tolist()),
                "driver_temperatures": _rounded(status.driver_temperatures.tolist()),
            }
            self._json("/drives", at, drives)
        forces = sample.read_forces
        if forces is not None:
            tool = _rounded(forces.tool.tolist(), FORCE)
            external = _rounded(forces.external_torques.tolist(), FORCE)
            if tool[0] is not None or external[0] is not None:
                wrench = {
                    "force": dict(zip("xyz", tool[:3], strict=True)),
                    "torque": dict(zip("xyz", tool[3:], strict=True)),
                    "external_torques": external,
                }
                self._if_changed("/wrench", at, wrench)

    def flange(self, pose: Pose | None) -> None:
        """Take where the flange is, seen from the tip of the tool; None if nobody tells."""
        if pose is None:
            self._flange = None
            return
        stamp = Timestamp(sec=0, nsec=0)
        self._flange = _transform(stamp, "tcp", "flange", _transform_numbers(pose))
        self._pose = None

    def command(
        self,
        at: float,
        lane: str,
        function: str,
        arguments: tuple[Any, ...],
        result: Any,
        error: str,
        duration: float,
    ) -> None:
        """Write a call that is over, at the time of its begin."""
        found = {
            "function": function,
            "arguments": plain(arguments),
            "result": plain(result),
            "error": error,
            "duration": round(duration, 6),
            "lane": lane,
        }
        self._json("/commands", at - duration, found)

    def other(self, topic: str, at: float, values: dict[str, Any]) -> None:
        """Write a message of one of the channels in JSON."""
        self._json(topic, at, plain(values))

    def event(self, event: Event) -> None:
        """Write an event of the robot."""
        what = plain(event)
        del what["at"]
        self._json("/events", event.at, {"event": type(event).__name__, "what": what})

    def line(self, at: float, level: int, name: str, message: str, file: str, line: int) -> None:
        """Write a log line."""
        stamp, time_ns = self._times(at)
        kind = next(kind for least, kind in _LEVELS if level >= least)
        self._set.log.log(
            Log(timestamp=stamp, level=kind, message=message, name=name, file=file, line=line),
            log_time=time_ns,
        )

    # -- how -------------------------------------------------------------------------------------

    def _times(self, at: float) -> tuple[Timestamp, int]:
        # Whole microseconds: the digits below are noise, and three times in each message.
        micros = round(at * 1e6) + self._offset
        seconds, rest = divmod(micros, 1_000_000)
        return Timestamp(sec=seconds, nsec=rest * 1000), micros * 1000

    @staticmethod
    def _joints(
        channel: JointStatesChannel,
        stamp: Timestamp,
        time_ns: int,
        positions: Iterable[float],
        speeds: Sequence[float],
    ) -> None:
        joints = [
            JointState(
                name=name,
                position=round(position * ANGLE) / ANGLE,
                velocity=None if math.isnan(speed) else round(speed * SPEED) / SPEED,
            )
            for name, position, speed in zip(_NAMES, positions, speeds, strict=True)
        ]
        channel.log(JointStates(timestamp=stamp, joints=joints), log_time=time_ns)

    def _transforms(self, at: float, stamp: Timestamp, time_ns: int, pose: Pose) -> None:
        numbers = _transform_numbers(pose)
        again = self._due("/tf", at, _AGAIN)
        if numbers == self._pose and not again:
            return
        self._pose = numbers
        transforms = [_transform(stamp, "world", "tcp", numbers)]
        if again and self._flange is not None:
            transforms.append(self._flange)
        self._set.transforms.log(FrameTransforms(transforms=transforms), log_time=time_ns)

    def _due(self, topic: str, at: float, every: float) -> bool:
        """Whether a channel was not written for so long."""
        last = self._last.get(topic)
        if last is not None and at - last[0] < every:
            return False
        self._last[topic] = (at, None)
        return True

    def _if_changed(self, topic: str, at: float, values: dict[str, Any]) -> None:
        last = self._last.get(topic)
        if last is None or last[1] != values or at - last[0] >= _AGAIN:
            self._last[topic] = (at, values)
            self._json(topic, at, values)

    def _json(self, topic: str, at: float, values: dict[str, Any]) -> None:
        text = json.dumps(values, separators=(",", ":"), allow_nan=False, ensure_ascii=False)
        self._set.json[topic].log(text, log_time=self._times(at)[1])


def _fields(topic: str, io: Any) -> dict[str, Any]:
    """The fields of a channel that are attributes of a sample."""
    return {
        name: getattr(io, name) if kind is _FLAGS else _rounded(getattr(io, name), 4)
        for name, kind in _FIELDS[topic].items()
    }


def _rounded(values: Iterable[float], digits: int = _ROUGH) -> list[float | None]:
    """JSON knows nothing that is not a number."""
    return [round(value, digits) if math.isfinite(value) else None for value in values]


def _transform_numbers(pose: Pose) -> tuple[float, ...]:
    """Position and quaternion, x first and w not below 0, on their grids."""
    x, y, z, rx, ry, rz = pose
    cr, sr = math.cos(rx / 2), math.sin(rx / 2)
    cp, sp = math.cos(ry / 2), math.sin(ry / 2)
    cy, sy = math.cos(rz / 2), math.sin(rz / 2)
    w = cr * cp * cy + sr * sp * sy
    turned = (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        w,
    )
    sign = QUATERNION if w >= 0.0 else -QUATERNION
    return (
        *(round(value * LENGTH) / LENGTH for value in (x, y, z)),
        *(round(value * sign) / QUATERNION for value in turned),
    )


def _transform(
    stamp: Timestamp, parent: str, child: str, numbers: tuple[float, ...]
) -> FrameTransform:
    x, y, z, qx, qy, qz, qw = numbers
    return FrameTransform(
        timestamp=stamp,
        parent_frame_id=parent,
        child_frame_id=child,
        translation=Vector3(x=x, y=y, z=z),
        rotation=Quaternion(x=qx, y=qy, z=qz, w=qw),
    )


def plain(value: Any) -> Any:
    """A value in the types that JSON knows; None for what is not a number."""
    if isinstance(value, enum.Enum):
        return value.name
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, str | bool | int | None):
        return value
    return _plain_parts(value)


def _plain_parts(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    elif (named := getattr(value, "_asdict", None)) is not None:
        value = named()
    if isinstance(value, dict):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(each) for each in value]
    if isinstance(value, bytes | bytearray):
        return value.hex()
    listed = getattr(value, "tolist", None)
    return str(value) if listed is None else plain(listed())
