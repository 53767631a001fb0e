"""A recording that is read back: messages, arrays by channel, tables for other programs."""

from __future__ import annotations

import functools
import json
import math
from contextlib import contextmanager, suppress
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, NamedTuple, ParamSpec, TypeVar

import numpy as np

from aioduco.errors import DucoError, MissingExtra, ParameterError, RecordingError
from aioduco.models.ranges import FILE, FOLDER
from aioduco.recording.container import McapFile, McapMessage
from aioduco.recording.protobuf import DECODERS

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray


#: longest message of JSON [bytes]; its values take many times as much
_LONGEST: Final = 1 << 24
#: depth up to which nested fields become fields of their own
_DEEPEST: Final = 16


class RecordedMessage(NamedTuple):
    """A message of a recording.

    Attributes:
        topic: its channel, such as "/commands".
        time: seconds since the recording began.
        time_ns: the same moment in nanoseconds since 1970.
        data: its content.
    """

    topic: str
    time: float
    time_ns: int
    data: dict[str, Any]


def read(path: str | os.PathLike[str]) -> RecordedRun:
    """Read a recording, as far as it is complete.

    A long one takes seconds, and so do its arrays: in an event loop, call them on a thread.

        run = aioduco.recording.read("run.mcap")
        joints = run.arrays("/joint_states")
        plt.plot(joints["time"], joints["position"])

    Args:
        path: the file. If it was cut off or damaged, it is read up to there: see
            `RecordedRun.complete`.

    Raises:
        ParameterError: the path is not the name of a file.
        RecordingError: the file cannot be opened, is not an MCAP file, has another compression, or
            unpacks to much more than its size.
        MissingExtra: the extra `record` is not installed.
    """
    return RecordedRun(FILE("path", path))


class RecordedRun:
    """A recording. The file is read once; each channel is decoded when it is used.

    Attributes:
        path: the file.
        metadata: texts about the recording: "library", "controller", "address", "arm", "started".
        started_ns: its begin, from which the times of its messages count [ns since 1970].
        complete: whether the recording was ended properly, and the file contains all of it. If not,
            the program was killed, the file could not be written any more, or it is damaged.
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
        started = self.metadata.get("started", "0")
        try:
            start = int(started)
        except ValueError:
            start = -1
        if not 0 <= start < 1 << 63:  # the file is damaged there
            start, self.complete = 0, False
        self.started_ns: int = start or min(times, default=0)
        self._end = max(ends, default=self.started_ns)

    def __repr__(self) -> str:
        cut = "" if self.complete else ", cut off"
        count = sum(self.topics.values())
        return f"<RecordedRun {self.path.name}, {self.duration:.1f} s, {count} messages{cut}>"

    @property
    def duration(self) -> float:
        """Seconds from its begin to its last message."""
        return (self._end - self.started_ns) * 1e-9

    @cached_property
    def topics(self) -> dict[str, int]:
        """Its channels, with the number of messages of each."""
        return {topic: len(messages) for topic, messages in sorted(self._messages.items())}

    def messages(self, *topics: str) -> Iterator[RecordedMessage]:
        """Iterate over the messages, in the order of their times.

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
                (message.time_ns - self.started_ns) * 1e-9,
                message.time_ns,
                _decoded(message),
            )

    def arrays(self, topic: str) -> dict[str, NDArray[Any]]:
        """Return all messages of a channel as arrays of equal length, one for each field.

        A field of numbers has shape (n,) or (n, k), with NaN for missing numbers; one of whole
        numbers alone, such as a task's id, is int64. Any other field is an array of objects. A
        nested field has both names: "force.x".

        Args:
            topic: the channel, such as "/joint_states"; see `topics`.

        Returns:
            The arrays by field, with "time" in seconds since the recording began, also where the
            messages of another maker have a field of this name.

        Raises:
            ParameterError: there is no such channel in this recording.
            RecordingError: its messages are of a kind that is not known, or one is damaged.
        """
        if not isinstance(topic, str) or topic not in self._messages:
            there = ", ".join(self.topics) or "none"
            raise ParameterError("topic", topic, f"a channel of this recording: {there}")
        messages = self._messages[topic]
        # differences first: the times themselves may be beyond 64 bits with a sign
        times = np.array([float(message.time_ns - self.started_ns) for message in messages])
        rows = [dict(_flat(_decoded(message))) for message in messages]
        names = dict.fromkeys(name for row in rows for name in row if name != "time")
        return {
            "time": times * 1e-9,
            **{name: _array([row.get(name) for row in rows]) for name in names},
        }

    def to_csv(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write each channel as a CSV file, with a column for each number.

        Args:
            folder: the folder to write to; it is created if it does not exist.

        Returns:
            The files.

        Raises:
            ParameterError: the folder is not the name of one.
            RecordingError: a message is damaged, or a file cannot be written.
        """
        from aioduco.recording.tables import write_csv  # noqa: PLC0415 - loaded when it is used

        with _written(folder) as target:
            return write_csv(self._channels(), target)

    def to_parquet(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write each channel as a Parquet file, with a column for each number. Needs pyarrow.

        Args:
            folder: the folder to write to; it is created if it does not exist.

        Returns:
            The files.

        Raises:
            ParameterError: the folder is not the name of one.
            RecordingError: a message is damaged, or a file cannot be written.
            MissingExtra: the extra `parquet` is not installed.
        """
        from aioduco.recording.tables import write_parquet  # noqa: PLC0415 - loaded when it is used

        with _written(folder) as target:
            return write_parquet(self._channels(), self.metadata, target)

    def _channels(self) -> Iterator[tuple[str, dict[str, NDArray[Any]]]]:
        return ((topic, self.arrays(topic)) for topic in self.topics)

    def to_mcap(self, path: str | os.PathLike[str]) -> Path:
        """Write it as an MCAP file with an index, for Rerun and viewers that need random access.

        The messages are unchanged, and the file is larger by half. From a recording that was cut
        off, this makes a complete file, up to the cut.

        Args:
            path: the file; an existing file is not overwritten.

        Returns:
            The file.

        Raises:
            ParameterError: the path is not the name of a file.
            RecordingError: the file exists, or cannot be written.
            MissingExtra: the extra `record` is not installed.
        """
        with MissingExtra.named("an index", "record"):
            from aioduco.recording.channels import write_indexed  # noqa: PLC0415 - an extra
        target = FILE("path", path)
        messages = [message for each in self._messages.values() for message in each]
        messages.sort(key=lambda message: message.time_ns)
        try:
            write_indexed(target, messages, self._texts)
        except OSError as exc:
            raise RecordingError(f"{target} cannot be written: {exc}") from exc
        return target


@contextmanager
def _written(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """The folder of tables, which is made; what cannot be written is a `RecordingError`."""
    target = FOLDER("folder", folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
        yield target
    except OSError as exc:
        raise RecordingError(f"{exc.filename or target} cannot be written: {exc}") from exc


def _decoded(message: McapMessage) -> dict[str, Any]:
    channel = message.channel
    name = channel.schema.name if channel.schema is not None else ""
    if channel.encoding != "json" and name not in DECODERS:
        raise RecordingError(
            f"messages of {channel.topic:.200} are not known here: {name or 'no schema':.200}"
        )
    if channel.encoding == "json" and len(message.data) > _LONGEST:
        raise RecordingError(
            f"a message of {channel.topic:.200} has {len(message.data)} bytes, more than {_LONGEST}"
        )
    try:
        if channel.encoding == "json":
            return {**json.loads(bytes(message.data))}
        return DECODERS[name](message.data)
    except Exception as error:  # a file of somebody else may hold anything
        raise RecordingError(
            f"a message of {channel.topic:.200} at {message.time_ns} ns cannot be read: "
            f"{type(error).__name__}: {error!s:.200}"
        ) from error


def _flat(values: Mapping[str, Any], before: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Iterate over the fields of a message, nested ones included; those too deep stay objects."""
    for name, value in values.items():
        if isinstance(value, dict) and depth < _DEEPEST:
            yield from _flat(value, f"{before}{name}.", depth + 1)
        else:
            yield before + name, value


def _array(values: Sequence[Any]) -> NDArray[Any]:
    """Return one field of all messages as an array."""
    kinds = {type(value) for value in values} - {type(None)}
    if kinds == {int} and None not in values:  # such as a task's id
        with suppress(OverflowError):
            return np.array(values, dtype=np.int64)
    if kinds <= {int, float}:
        with suppress(OverflowError):  # a whole number of another maker's, beyond all floats
            return np.array([math.nan if value is None else value for value in values], dtype=float)
    if kinds == {bool} and None not in values:
        return np.array(values, dtype=bool)
    if kinds == {list} and (table := _table(values)) is not None:
        return table
    array = np.empty(len(values), dtype=object)
    array[:] = values
    return array


def _table(values: Sequence[list[Any] | None]) -> NDArray[Any] | None:
    """Return lists of numbers as rows; None if they differ in length, or have other values."""
    lengths = {len(value) for value in values if value is not None}
    kinds = {type(each) for value in values if value is not None for each in value}
    if len(lengths) != 1 or not kinds - {type(None)} or not kinds <= {int, float, bool, type(None)}:
        return None
    if kinds == {bool} and None not in values:
        return np.array(values, dtype=bool)
    (length,) = lengths
    missing = [math.nan] * length
    rows = [
        missing if row is None else [math.nan if each is None else each for each in row]
        for row in values
    ]
    try:
        return np.array(rows, dtype=float)
    except OverflowError:  # as above
        return None


P = ParamSpec("P")
T = TypeVar("T")

#: what content raises that is not as the channel's format says
_UNREADABLE = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)


def of_any_maker(function: Callable[P, T]) -> Callable[P, T]:
    """A function that reads contents of a recording; it raises `RecordingError` if it cannot."""

    @functools.wraps(function)
    def reading(*args: P.args, **kwargs: P.kwargs) -> T:
        try:
            return function(*args, **kwargs)
        except DucoError:
            raise
        except _UNREADABLE as error:
            raise RecordingError(
                f"the recording's channels are not as aioduco writes them: {error!r:.300}"
            ) from error

    return reading
