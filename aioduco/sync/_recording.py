"""A recording for programs that wait."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import logging
    from pathlib import Path
    from types import TracebackType
    from typing import Self

    from aioduco.recording import recorder
    from aioduco.recording.recorder import RecordingStatistics
    from aioduco.sync._runner import Runner

__all__ = ["Recording"]


class Recording:
    """A recording of one robot: `Robot.record` makes it, `with` or `start` begins it."""

    def __init__(self, runner: Runner, recording: recorder.Recording) -> None:
        self._runner = runner
        self._recording = recording

    def __repr__(self) -> str:
        return repr(self._recording)

    @property
    def handler(self) -> logging.Handler:
        """Records log lines; a program may add it to its own loggers."""
        return self._recording.handler

    @property
    def path(self) -> Path:
        """The file; if there was one of its name, a number was added to it."""
        return self._recording.path

    @property
    def running(self) -> bool:
        """Whether it records."""
        return self._recording.running

    @property
    def over(self) -> bool:
        """Whether it has ended."""
        return self._recording.over

    @property
    def error(self) -> Exception | None:
        """Why it ended by itself, such as a full disk; None if it did not."""
        return self._recording.error

    def statistics(self) -> RecordingStatistics:
        """Figures since its start."""
        return self._recording.statistics()

    def start(self) -> Self:
        """Open the file, and record from now on.

        Raises:
            RobotStateError: the robot is not open, or the recording was started before.
            RecordingError: the file cannot be written.
            MissingExtra: the extra `record` is not installed.
        """
        self._runner.call(self._recording.start(), undo=lambda _: self._recording.stop())
        return self

    def stop(self) -> None:
        """End the recording: what was seen is written, and the file is closed.

        What fails is logged and not raised: `error` says whether the file is whole.
        """
        if self._runner.running:
            self._runner.call(self._recording.stop())

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.stop()
