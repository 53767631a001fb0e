"""What the trial of a program changes in this package: see `aioduco.testing.preflight`.

A preflight runs a program on a simulated arm, in a process that is started for that. There,
`current` is the trial from before the program begins until the process ends; in every other process
it is None, and nothing here is called. It belongs to the process and not to a context variable,
since threads that the program starts are tried, too.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, Any, Self, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from _typeshed import DataclassInstance

    Settings = TypeVar("Settings", bound=DataclassInstance)


class Moment(float):
    """A time on the clock of a program that is tried [s of its `time.monotonic`].

    Attributes:
        wall: the same on the wall clock, by which this package measures [s of `time.monotonic`].
    """

    wall: float

    @classmethod
    def of(cls, seen: float, wall: float) -> Self:
        """A moment on both clocks."""
        moment = cls(seen)
        moment.wall = wall
        return moment


class Trial(ABC):
    """What is asked or told in the process of a trial. Any thread may call it."""

    # -- the network ---------------------------------------------------------------------------

    @abstractmethod
    def endpoint(self, host: str, port: int, timeout: float) -> tuple[str, int, float]:
        """Where connections to a host and port lead, and the time limit to make them [s]."""

    @abstractmethod
    def settings(self, given: Settings) -> Settings:
        """The settings that are used in place of those of a robot or a stream."""

    @abstractmethod
    def call(
        self, name: str, args: tuple[Any, ...], *, vendor: bool = False
    ) -> Callable[[Any, BaseException | None], object]:
        """A function of the wire is about to be called.

        Args:
            name: the function.
            args: its arguments.
            vendor: whether the vendor's class calls it, which raises no error of a motion.

        Returns:
            A function that is called once at its end, with the answer and the error.
        """

    # -- the program's time --------------------------------------------------------------------

    @abstractmethod
    def now(self) -> float:
        """The program's time [s of its `time.monotonic`]."""

    @abstractmethod
    def sleep(self, seconds: float) -> None:
        """Let so much of the program's time pass, as the program's `time.sleep` does [s]."""

    @abstractmethod
    def untimed(self) -> AbstractContextManager[object]:
        """A block that takes none of the program's time, however long this computer needs."""

    @abstractmethod
    def waiting(self) -> AbstractContextManager[Callable[[], object]]:
        """A block in which the calling thread waits for the thread of its robot.

        Returns:
            The block, whose value is called when what is waited for has come, from any thread.
        """

    @abstractmethod
    def at_own_pace(self, over: Callable[[], bool]) -> None:
        """From now on, until `over` returns true, the program's time is the wall clock's."""

    # -- motions -------------------------------------------------------------------------------

    @abstractmethod
    def made(self, motion: object) -> None:
        """A motion was made, and not sent."""

    @abstractmethod
    def forgotten(self, motion: object, text: str, *, used: bool) -> None:
        """A motion is about to be deleted.

        Args:
            motion: the motion.
            text: the motion for people.
            used: whether it was sent.
        """

    @abstractmethod
    def started(self) -> AbstractContextManager[object]:
        """A block that sends a motion, whose end the program awaits at another line."""

    # -- the envelope --------------------------------------------------------------------------

    @abstractmethod
    def checked(self, name: str) -> None:
        """The running task begins to check a motion against the envelope, which it then sends."""

    @abstractmethod
    def beyond(self, name: str, found: object) -> bool:
        """Whether a motion that would lead beyond the envelope is sent nevertheless.

        Args:
            name: the function of the wire.
            found: the limit.
        """

    @abstractmethod
    def slowed(self, share: float) -> None:
        """The motion that is checked gets this share of its speed."""


#: the trial that this process carries out; None in every process but that of a preflight
current: Trial | None = None


def moment(at: float) -> float:
    """A moment that has just passed [s of `time.monotonic`], for a value that the program reads."""
    if current is None or isinstance(at, Moment):
        return at
    return Moment.of(current.now(), at)


def wall(at: float) -> float:
    """What `moment` was given: a time to compare with those that this package has measured."""
    return at.wall if isinstance(at, Moment) else at


def untimed() -> AbstractContextManager[object]:
    """A block that takes none of the time of a program that is tried."""
    return nullcontext() if current is None else current.untimed()


def waiting() -> AbstractContextManager[Callable[[], object] | None]:
    """A block in which the calling thread waits for the thread of its robot."""
    return nullcontext() if current is None else current.waiting()


def started() -> AbstractContextManager[object]:
    """A block that sends a motion, whose end the program awaits at another line."""
    return nullcontext() if current is None else current.started()


@contextmanager
def at_own_pace() -> Iterator[None]:
    """A block in which the time of a program that is tried is the wall clock's."""
    over = False
    if current is not None:
        current.at_own_pace(lambda: over)
    try:
        yield
    finally:
        over = True
