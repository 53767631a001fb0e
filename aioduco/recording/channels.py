"""The messages of a recorded or published robot: the channels, their schemas and units.

A channel has a schema of Foxglove's if there is one; the other channels are JSON with a schema.
Numbers that are measured at each sample are rounded to a grid finer than the arm's repeatability,
since digits of noise would be most of a file's size: see `ANGLE`, `SPEED` and so on. A channel
whose values seldom change is written when they change, and every five seconds. Joints, which are
most of the data, are encoded here: the library's classes take three times as long.
"""

from __future__ import annotations

import json
import math
import struct
import time
from importlib import resources
from typing import TYPE_CHECKING, Any, BinaryIO, Final, Protocol

import foxglove
from foxglove.channels import FrameTransformsChannel, LogChannel
from foxglove.mcap import MCAPCompression, MCAPWriteOptions
from foxglove.messages import (
    FrameTransform,
    FrameTransforms,
    JointStates,
    Log,
    LogLevel,
    Quaternion,
    Timestamp,
    Vector3,
)

from aioduco._process import trial
from aioduco._process.platform import private
from aioduco.models.numpy_on_use import json_value
from aioduco.models.quaternions import from_rpy

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from aioduco.models.pose import Pose
    from aioduco.models.state import IOStatus
    from aioduco.recording.container import McapChannel, McapMessage, McapSchema
    from aioduco.supervision.events import Event
    from aioduco.supervision.state_feed import Snapshot


# Powers of two: so the lower bits of each number are zeros, which compress well.
#: steps per rad of recorded angles: a step is 7.6 µrad, at a reach of 1 m a third of the
#: repeatability of arms (0.02 mm)
ANGLE: Final = 2.0**17
#: steps per rad/s of recorded joint speeds: a step is 0.98 mrad/s
SPEED: Final = 2.0**10
#: steps per m of recorded positions: a step is 7.6 µm
LENGTH: Final = 2.0**17
#: steps per 1 of the four numbers of a recorded rotation, which is then accurate to 15 µrad
QUATERNION: Final = 2.0**17
#: decimal digits of recorded forces: 1 mN, 1 mN·m
FORCE: Final = 3
#: decimal digits of recorded temperatures and analogue signals
_ROUGH: Final = 2
#: seconds after which a channel is written even if nothing changed
_REPEAT_EVERY: Final = 5.0
#: seconds between two messages about the drives
_DRIVES_EVERY: Final = 0.2
#: step of the times of samples [ns]: 16 µs, less than their delay
_SAMPLED: Final = 1 << 14
#: decimal digits of recorded currents, which are in ‰ of the rated ones
_CURRENT: Final = 1
#: seconds between two transforms: they can be computed from the joints, which each sample has
_TRANSFORMS_EVERY: Final = 0.039

_NAMES: Final = tuple(f"joint_{number}" for number in range(1, 7))
_LEVELS: Final = (
    (50, LogLevel.Fatal),
    (40, LogLevel.Error),
    (30, LogLevel.Warning),
    (20, LogLevel.Info),
    (0, LogLevel.Debug),
)

_FLAGS: Final = {"type": "array", "items": {"type": "boolean"}}
#: fields of the JSON channels as JSON Schema, by channel
_FIELDS: Final[dict[str, dict[str, Any]]] = json.loads(
    resources.files("aioduco.recording").joinpath("json_channels.json").read_text("utf-8")
)


class Writable(Protocol):
    """The target to which a file is written."""

    def write(self, data: bytes | bytearray) -> int:
        """Write some bytes."""
        ...

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go to a position."""
        ...

    def flush(self) -> None:
        """Write out the buffered bytes."""
        ...


class _ChannelSet:
    """The channels of one file or server. The library never frees them, so they are reused."""

    def __init__(self) -> None:
        self.context = foxglove.Context()
        self.joints, self.setpoints = (
            foxglove.Channel(
                topic,
                schema=JointStates.get_schema(),
                message_encoding="protobuf",
                context=self.context,
            )
            for topic in ("/joint_states", "/joint_setpoints")
        )
        self.transforms = FrameTransformsChannel("/tf", context=self.context)
        self.log = LogChannel("/log", context=self.context)
        self.json = {
            topic: foxglove.Channel(
                topic, schema=_schema(topic, fields), message_encoding="json", context=self.context
            )
            for topic, fields in _FIELDS.items()
        }


def _schema(topic: str, fields: dict[str, Any]) -> dict[str, Any]:
    return {"type": "object", "title": f"aioduco.{topic[1:]}", "properties": fields}


#: the first time that no message can have: its seconds have 32 bits [ns since 1970]
_LAST: Final = (1 << 32) * 1_000_000_000

#: sets that are not in use
_free: list[_ChannelSet] = []


class MessageChannels:
    """Logs messages about a robot to the file or server at its `context`; on one thread.

    Times are seconds of `time.monotonic()`. Messages have nanoseconds since 1970, computed by the
    difference of the two clocks at the beginning.

    Args:
        clock_offset: the difference of the clocks [ns].

    Attributes:
        messages: number of messages that were logged.

    Raises:
        ValueError: the clock of this computer shows a time that no message can have.
    """

    def __init__(self, clock_offset: int) -> None:
        if not 0 <= time.monotonic_ns() + clock_offset < _LAST:
            raise ValueError("the clock of this computer is before 1970 or after 2106: set it")
        self.messages: int = 0
        self._set = _free.pop() if _free else _ChannelSet()
        self._offset = clock_offset
        self._released = False
        self._flange: tuple[float, ...] | None = None
        self._flange_written = False
        self._pose: tuple[float, ...] | None = None
        self._last: dict[str, tuple[float, Any]] = {}

    @property
    def context(self) -> foxglove.Context:
        """The library's context, which connects the channels to a file or a server."""
        return self._set.context

    def release(self) -> None:
        """Make the channels available for reuse: the file or server is closed."""
        if not self._released:
            self._released = True
            _free.append(self._set)

    # -- what is recorded ------------------------------------------------------------------------

    def sample(self, sample: Snapshot) -> None:
        """Write a sample of the state."""
        status, states, io = sample.status, sample.states, sample.io
        at = trial.wall(status.received_at)
        stamp, time_ns = self._times(at, _SAMPLED)
        joints = _joint_states(time_ns, status.joints, status.joint_speeds.tolist())
        self._set.joints.log(joints, log_time=time_ns)
        expected = status.expected_joint_speeds.tolist()
        setpoints = _joint_states(time_ns, status.expected_joints, expected)
        self._set.setpoints.log(setpoints, log_time=time_ns)
        self.messages += 2
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
        for topic in ("/io", "/registers"):
            self._fields_if_changed(topic, at, io)
        if self._due("/drives", at, _DRIVES_EVERY):
            drives = {
                "currents": _rounded(status.joint_currents.tolist(), _CURRENT),
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
        """Set the pose of the flange in the frame of the tool's tip; None if it is unknown."""
        numbers = None if pose is None else _transform_numbers(pose)
        self._flange_written = self._flange_written and numbers == self._flange
        self._flange = numbers

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
        """Write a finished call, at the time of its start."""
        found = {
            "function": function,
            "arguments": json_value(arguments, recorded=True),
            "result": json_value(result, recorded=True),
            "error": error,
            "duration": round(duration, 6),
            "lane": lane,
        }
        self._json("/commands", at - duration, found)

    def other(self, topic: str, at: float, values: dict[str, Any]) -> None:
        """Write a message of one of the channels in JSON."""
        self._json(topic, at, json_value(values, recorded=True))

    def event(self, event: Event) -> None:
        """Write an event of the robot."""
        what = json_value(event, recorded=True)
        del what["at"]
        self._json("/events", trial.wall(event.at), {"event": type(event).__name__, "what": what})

    def line(self, at: float, level: int, name: str, message: str, file: str, line: int) -> None:
        """Write a log line."""
        stamp, time_ns = self._times(at)
        kind = next(kind for least, kind in _LEVELS if level >= least)
        said, name, file = map(_written, (message, name, file))
        self._set.log.log(
            Log(timestamp=stamp, level=kind, message=said, name=name, file=file, line=line),
            log_time=time_ns,
        )
        self.messages += 1

    # -- encoding --------------------------------------------------------------------------------

    def _times(self, at: float, step: int = 1000) -> tuple[Timestamp, int]:
        # In steps of at least a microsecond: the digits below are noise.
        time_ns = (round(at * 1e9) + self._offset + step // 2) // step * step
        seconds, rest = divmod(time_ns, 1_000_000_000)
        return Timestamp(sec=seconds, nsec=rest), time_ns

    def _transforms(self, at: float, stamp: Timestamp, time_ns: int, pose: Pose) -> None:
        if not self._due("/tf", at, _TRANSFORMS_EVERY):
            return
        numbers = _transform_numbers(pose)
        again = self._due("/tf again", at, _REPEAT_EVERY)
        flange = None if self._flange_written and not again else self._flange
        if numbers == self._pose and flange is None and not again:
            return
        self._pose = numbers
        transforms = [_transform(stamp, "world", "tcp", numbers)]
        if flange is not None:
            transforms.append(_transform(stamp, "tcp", "flange", flange))
            self._flange_written = True
        self._set.transforms.log(FrameTransforms(transforms=transforms), log_time=time_ns)
        self.messages += 1

    def _due(self, topic: str, at: float, every: float, values: Any = None) -> bool:
        """Whether a channel has other values, or these for `every` seconds; if so, note them."""
        last = self._last.get(topic)
        if last is not None and at - last[0] < every and last[1] == values:
            return False
        self._last[topic] = (at, values)
        return True

    def _if_changed(self, topic: str, at: float, values: dict[str, Any]) -> None:
        if self._due(topic, at, _REPEAT_EVERY, values):
            self._json(topic, at, values)

    def _fields_if_changed(self, topic: str, at: float, io: IOStatus) -> None:
        """As `_if_changed`, for attributes of a sample; they are rounded only to be written."""
        values = tuple([getattr(io, name) for name in _FIELDS[topic]])
        if self._due(topic, at, _REPEAT_EVERY, values):
            kinds = _FIELDS[topic].items()
            found = {
                name: value if kind == _FLAGS else _rounded(value, 4)
                for (name, kind), value in zip(kinds, values, strict=True)
            }
            self._json(topic, at, found)

    def _json(self, topic: str, at: float, values: dict[str, Any]) -> None:
        text = json.dumps(values, separators=(",", ":"), allow_nan=False, ensure_ascii=False)
        self._set.json[topic].log(_written(text), log_time=self._times(at)[1])
        self.messages += 1


class FileChannels(MessageChannels):
    """Writes messages about a robot to an MCAP file.

    Args:
        target: the target to which the file is written.
        metadata: texts about the recording; `clock_offset` is the difference of the clocks [ns].
    """

    def __init__(self, target: Writable, metadata: dict[str, str]) -> None:
        super().__init__(int(metadata["clock_offset"]))
        # one thread: the other processors are for the robot's program
        options = MCAPWriteOptions(
            profile="aioduco",
            chunk_size=None,
            compression=MCAPCompression.Zstd,
            compression_threads=0,
            disable_seeking=True,
            # An index of messages takes 16 bytes for each message, more than most messages here. If
            # there is only an index of chunks, some readers find no message. Without both they read
            # the whole file.
            emit_message_indexes=False,
            emit_chunk_indexes=False,
        )
        try:
            self._writer = foxglove.open_mcap(target, context=self.context, writer_options=options)
        except BaseException:
            self.release()
            raise
        try:
            self.metadata("aioduco", metadata)
        except BaseException:
            self.close()
            raise

    def metadata(self, name: str, values: dict[str, str]) -> None:
        """Write texts about the recording itself."""
        self._writer.write_metadata(name, values)

    def flush(self) -> None:
        """End the chunk."""
        self._writer.flush()

    def close(self) -> None:
        """End the file."""
        if not self._released:
            try:
                self._writer.close()
            finally:
                self.release()


def write_indexed(
    path: Path, messages: Iterable[McapMessage], metadata: Mapping[str, dict[str, str]]
) -> None:
    """Write messages to a file with indexes of its chunks and of its messages.

    Args:
        path: the file, which must not exist yet.
        messages: the messages, in the order of their times.
        metadata: texts by the name of their record.

    Raises:
        OSError: the file exists, or cannot be written; there is none then.
    """
    file = open(path, "xb", opener=private)  # noqa: SIM115 - closed below
    try:
        with file:
            _write_indexed(file, messages, metadata)
    except BaseException as error:
        path.unlink(missing_ok=True)
        if isinstance(error, RuntimeError):  # the library has no other error for this
            raise OSError(str(error)) from error
        raise


def _write_indexed(
    file: BinaryIO, messages: Iterable[McapMessage], metadata: Mapping[str, dict[str, str]]
) -> None:
    context = foxglove.Context()
    options = MCAPWriteOptions(profile="aioduco", compression=MCAPCompression.Zstd)
    channels: dict[McapChannel, foxglove.Channel] = {}
    try:
        with foxglove.open_mcap(file, context=context, writer_options=options) as writer:
            for name, texts in metadata.items():
                writer.write_metadata(name, texts)
            for message in messages:
                kind = message.channel
                if kind not in channels:
                    channels[kind] = foxglove.Channel(
                        kind.topic,
                        message_encoding=kind.encoding,
                        schema=_as_written(kind.schema),
                        context=context,
                    )
                channels[kind].log(bytes(message.data), log_time=message.time_ns)
    finally:
        for channel in channels.values():
            channel.close()


def _as_written(schema: McapSchema | None) -> foxglove.Schema | None:
    if schema is None:
        return None
    return foxglove.Schema(name=schema.name, encoding=schema.encoding, data=schema.data)


class ServerChannels(MessageChannels):
    """Sends messages about a robot to the watchers of a WebSocket server.

    The library sends on threads of its own. A watcher that is too slow loses its oldest waiting
    messages.

    Args:
        host: address to listen on.
        port: port to listen on; 0 for a free one.
        metadata: as for a file; `address` is the robot's name for watchers.

    Raises:
        OSError: it cannot listen there.
    """

    def __init__(self, host: str, port: int, metadata: dict[str, str]) -> None:
        super().__init__(int(metadata["clock_offset"]))
        name = f"aioduco {metadata['address']}"
        try:
            self._server = foxglove.start_server(
                name=name, host=host, port=port, context=self.context
            )
        except RuntimeError as exc:  # the library has no other error for this
            self.release()
            raise OSError(str(exc)) from exc
        self.port: int = self._server.port

    def close(self) -> None:
        """Close the connections of the watchers, and stop listening."""
        self._server.stop()
        self.release()


def _written(text: str) -> str:
    """A text as UTF-8 has it: halves of surrogate pairs, as in names of files, become "?"."""
    return text if text.isascii() else text.encode("utf-8", "replace").decode()


def _message_format() -> tuple[str, list[Any]]:
    """Return the `struct` format of a JointStates of six joints, and its parts with the constants.

    Protobuf's wire format: a timestamp of seconds and nanoseconds, then for each joint its name,
    position and velocity. The two whole numbers always have five bytes each. So all messages have
    the same length, and compress better.
    """
    layout = "<3s5ss5s"
    parts: list[Any] = [b"\x0a\x0c\x08", b"", b"\x10", b""]
    for name in _NAMES:
        text = name.encode()
        head = b"\x12" + bytes([len(text) + 20]) + b"\x0a" + bytes([len(text)]) + text + b"\x11"
        layout += f"{len(head)}sdsd"
        parts += [head, 0.0, b"\x19", 0.0]
    return layout, parts


_LAYOUT, _PARTS = _message_format()
_PACK: Final = struct.Struct(_LAYOUT).pack
#: constant that is added to a number and subtracted again, which rounds it to the grid
_TO_ANGLE: Final = 1.5 * 2.0**52 / ANGLE
_TO_SPEED: Final = 1.5 * 2.0**52 / SPEED


def _joint_states(time_ns: int, positions: Iterable[float], speeds: Iterable[float]) -> bytes:
    """Encode a JointStates of six joints; an unknown speed is NaN."""
    seconds, rest = divmod(time_ns, 1_000_000_000)
    parts = _PARTS.copy()
    parts[1], parts[3] = _five_bytes(seconds), _five_bytes(rest)
    parts[5::4] = [position + _TO_ANGLE - _TO_ANGLE for position in positions]
    parts[7::4] = [speed + _TO_SPEED - _TO_SPEED for speed in speeds]
    return _PACK(*parts)


def _five_bytes(number: int) -> bytes:
    """Encode a whole number from 0 to 2**35 - 1 as protobuf's varint of five bytes."""
    return bytes(
        (
            number & 127 | 128,
            number >> 7 & 127 | 128,
            number >> 14 & 127 | 128,
            number >> 21 & 127 | 128,
            number >> 28,
        )
    )


def _rounded(values: Iterable[float], digits: int = _ROUGH) -> list[float | None]:
    """Round numbers; one that is not finite becomes None, since JSON cannot represent it."""
    return [round(value, digits) if math.isfinite(value) else None for value in values]


def _transform_numbers(pose: Pose) -> tuple[float, ...]:
    """Return position and quaternion, x first and w at least 0, rounded to their grids."""
    x, y, z, rx, ry, rz = pose
    w, *axis = from_rpy(rx, ry, rz)
    sign = QUATERNION if w >= 0.0 else -QUATERNION
    return (
        *(round(value * LENGTH) / LENGTH for value in (x, y, z)),
        *(round(value * sign) / QUATERNION for value in (*axis, w)),
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
