"""A recording and a publication for blocking programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import logging
    from pathlib import Path
    from types import TracebackType
    from typing import Self

    from aioduco.recording import publication, recorder
    from aioduco.recording.publication import PublicationStatistics
    from aioduco.recording.recorder import RecordingStatistics, RobotObserver
    from aioduco.sync._runner import Runner

__all__ = ["Publication", "Recording"]


class _Observer:
    """The common part of both: begin, end, and error."""

    def __init__(self, runner: Runner, observer: RobotObserver) -> None:
        self._runner = runner
        self._observer = observer

    def __repr__(self) -> str:
        return repr(self._observer)

    @property
    def handler(self) -> logging.Handler:
        """The handler for log lines; a program may add it to its own loggers."""
        return self._observer.handler

    @property
    def running(self) -> bool:
        """Whether the robot is being recorded or published."""
        return self._observer.running

    @property
    def over(self) -> bool:
        """Whether it has ended."""
        return self._observer.over

    @property
    def error(self) -> Exception | None:
        """Why it ended by itself, such as a full disk; None if it did not."""
        return self._observer.error

    def start(self) -> Self:
        """Begin to record or publish the robot.

        Raises:
            RobotStateError: the robot is not open, or this was started before.
            RecordingError: the file cannot be written, or the address cannot be listened on.
            MissingExtra: the extra `record` is not installed.
        """
        self._runner.call(self._observer.start(), undo=lambda _: self._observer.stop())
        return self

    def stop(self) -> None:
        """Write the remaining data, and close the file or the port.

        A failure is logged and not raised; it is in `error`.
        """
        if self._runner.running:
            self._runner.call(self._observer.stop())

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.stop()


class Recording(_Observer):
    """A recording of one robot: `Robot.record` makes it, `with` or `start` begins it."""

    def __init__(self, runner: Runner, recording: recorder.Recording) -> None:
        super().__init__(runner, recording)
        self._recording = recording

    @property
    def path(self) -> Path:
        """The file; if one of its name existed, a number was added to the name."""
        return self._recording.path

    def statistics(self) -> RecordingStatistics:
        """Figures since its start."""
        return self._recording.statistics()


class Publication(_Observer):
    """A robot published live: `Robot.publish` makes it, `with` or `start` begins it."""

    def __init__(self, runner: Runner, made: publication.Publication) -> None:
        super().__init__(runner, made)
        self._publication = made

    @property
    def port(self) -> int:
        """The port that it listens on; before the start, the requested one."""
        return self._publication.port

    @property
    def url(self) -> str:
        """The address to which watchers connect, such as `ws://127.0.0.1:8765`."""
        return self._publication.url

    def statistics(self) -> PublicationStatistics:
        """Figures since its start."""
        return self._publication.statistics()
