"""A recording that is read back: messages, arrays by channel, tables for other programs."""

from __future__ import annotations

import json
import math
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aioduco.errors import MissingExtra, ParameterError, RecordingError
from aioduco.recording.container import McapFile
from aioduco.recording.protobuf import DECODERS

if TYPE_CHECKING:
    import os
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from aioduco.recording.container import McapMessage

__all__ = ["RecordedMessage", "RecordedRun", "read"]


class RecordedMessage(NamedTuple):
    """A message of a recording.

    Attributes:
        topic: its channel, such as "/commands".
        time: seconds since the recording began.
        time_ns: the same moment in nanoseconds since 1970.
        data: what it says.
    """

    topic: str
    time: float
    time_ns: int
    data: dict[str, Any]


def read(path: str | os.PathLike[str]) -> RecordedRun:
    """Read a recording, as far as it is whole.

        run = aioduco.recording.read("run.mcap")
        joints = run.arrays("/joint_states")
        plt.plot(joints["time"], joints["position"])

    Args:
        path: the file. One that was cut off is read up to there: see `RecordedRun.complete`.

    Raises:
        RecordingError: it cannot be opened, is no MCAP file, or is packed in another way.
        MissingExtra: the extra `record` is not installed.
    """
    return RecordedRun(Path(path))


class RecordedRun:
    """A recording. It is read once, and decoded channel by channel, when it is asked for.

    Attributes:
        path: the file.
        metadata: texts about the recording: "library", "controller", "address", "arm", "started".
        complete: whether the recording was ended, and all of it is here. If not, its program was
            killed, or it could not be written any more.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        file = McapFile(path)
        by_topic: dict[str, list[McapMessage]] = {}
        for message in file.messages():
            by_topic.setdefault(message.channel.topic, []).append(message)
        for messages in by_topic.values():
            messages.sort(key=lambda message: message.time_ns)
        self._messages = by_topic
        self._texts = file.metadata
        self.metadata: dict[str, str] = file.metadata.get("aioduco", {})
        self.complete: bool = file.complete
        times = [messages[0].time_ns for messages in by_topic.values()]
        ends = [messages[-1].time_ns for messages in by_topic.values()]
        start = int(self.metadata.get("started", 0))
        self._start = start or min(times, default=0)
        self._end = max(ends, default=self._start)

    def __repr__(self) -> str:
        cut = "" if self.complete else ", cut off"
        count = sum(self.topics.values())
        return f"<RecordedRun {self.path.name}, {self.duration:.1f} s, {count} messages{cut}>"

    @property
    def started_ns(self) -> int:
        """When it began, in nanoseconds since 1970: what the times of its messages count from."""
        return self._start

    @property
    def duration(self) -> float:
        """Seconds from its begin to its last message."""
        return (self._end - self._start) * 1e-9

    @cached_property
    def topics(self) -> dict[str, int]:
        """Its channels, and how many messages each has."""
        return {topic: len(messages) for topic, messages in sorted(self._messages.items())}

    def messages(self, *topics: str) -> Iterator[RecordedMessage]:
        """Every message in the order of their times.

        Args:
            topics: the channels; none for all of them.
        """
        chosen = [
            message
            for topic, messages in self._messages.items()
            if not topics or topic in topics
            for message in messages
        ]
        chosen.sort(key=lambda message: message.time_ns)
        for message in chosen:
            yield RecordedMessage(
                message.channel.topic,
                (message.time_ns - self._start) * 1e-9,
                message.time_ns,
                _decoded(message),
            )

    def arrays(self, topic: str) -> dict[str, NDArray[Any]]:
        """All messages of a channel as arrays of one length, one for each field.

        A field of numbers is of shape (n,) or (n, k), with NaN for what is missing; any other is
        an array of objects. The fields of a part are called by both names: "force.x".

        Args:
            topic: the channel, such as "/joint_states"; see `topics`.

        Returns:
            The arrays by field, with "time" in seconds since the recording began.

        Raises:
            ParameterError: there is no such channel in this recording.
        """
        if topic not in self._messages:
            there = ", ".join(self.topics) or "none"
            raise ParameterError("topic", topic, f"a channel of this recording: {there}")
        messages = self._messages[topic]
        times = np.array([message.time_ns for message in messages], dtype=np.int64) - self._start
        rows = [dict(_flat(_decoded(message))) for message in messages]
        names = dict.fromkeys(name for row in rows for name in row)
        return {
            "time": times * 1e-9,
            **{name: _array([row.get(name) for row in rows]) for name in names},
        }

    def to_csv(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write each channel as a CSV file, with a column for each number.

        Args:
            folder: where to write; made if it is not there.

        Returns:
            The files.
        """
        from aioduco.recording.tables import write_csv  # noqa: PLC0415 - with what it needs

        return write_csv(self, Path(folder))

    def to_parquet(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write each channel as a Parquet file, with a column for each number. Needs pyarrow.

        Args:
            folder: where to write; made if it is not there.

        Returns:
            The files.

        Raises:
            MissingExtra: the extra `parquet` is not installed.
        """
        from aioduco.recording.tables import write_parquet  # noqa: PLC0415 - with what it needs

        return write_parquet(self, Path(folder))

    def to_mcap(self, path: str | os.PathLike[str]) -> Path:
        """Write it as an MCAP file with an index: what Rerun and viewers that jump about need.

        Every message is the same, and the file is larger by half. One that was cut off is whole
        then, as far as it went.

        Args:
            path: the file; one that exists is not written over.

        Returns:
            The file.

        Raises:
            RecordingError: it exists, or cannot be written.
            MissingExtra: the extra `record` is not installed.
        """
        try:
            from aioduco.recording.channels import write_indexed  # noqa: PLC0415 - an extra
        except ModuleNotFoundError as exc:
            raise MissingExtra("an index", exc.name or "foxglove-sdk", "record") from exc
        target = Path(path)
        messages = [message for each in self._messages.values() for message in each]
        messages.sort(key=lambda message: message.time_ns)
        try:
            write_indexed(target, messages, self._texts)
        except OSError as exc:
            raise RecordingError(f"{target} cannot be written: {exc}") from exc
        return target


def _decoded(message: McapMessage) -> dict[str, Any]:
    channel = message.channel
    if channel.encoding == "json":
        found: dict[str, Any] = json.loads(bytes(message.data))
        return found
    name = channel.schema.name if channel.schema is not None else ""
    if name not in DECODERS:
        raise RecordingError(
            f"messages of {channel.topic} are not known here: {name or 'no schema'}"
        )
    return DECODERS[name](message.data)


def _flat(values: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """The fields of a message, those of its parts included."""
    for name, value in values.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{before}{name}.")
        else:
            yield before + name, value


def _array(values: Sequence[Any]) -> NDArray[Any]:
    """One field of all messages."""
    kinds = {type(value) for value in values} - {type(None)}
    if kinds <= {int, float}:
        return np.array([math.nan if value is None else value for value in values], dtype=float)
    if kinds == {bool} and None not in values:
        return np.array(values, dtype=bool)
    if kinds == {list} and (table := _table(values)) is not None:
        return table
    array = np.empty(len(values), dtype=object)
    array[:] = values
    return array


def _table(values: Sequence[list[Any] | None]) -> NDArray[Any] | None:
    """Lists of numbers as rows; None if they are not of one length, or not of numbers."""
    lengths = {len(value) for value in values if value is not None}
    kinds = {type(each) for value in values if value is not None for each in value}
    if len(lengths) != 1 or not kinds - {type(None)} or not kinds <= {int, float, bool, type(None)}:
        return None
    if kinds == {bool} and None not in values:
        return np.array(values, dtype=bool)
    (length,) = lengths
    missing = [math.nan] * length
    return np.array(
        [
            missing if row is None else [math.nan if each is None else each for each in row]
            for row in values
        ],
        dtype=float,
    )
