"""What a call is answered with that is not carried out, and which calls are forgiven.

`Forgiving`: calls that a controller accepts although the manual forbids them, as public programs
show. A strict simulator refuses such calls, in order to find sloppy programs. A lenient one accepts
them, logs a warning once for each kind, and counts them.
"""

from __future__ import annotations

import logging
import threading
from collections import Counter

from aioduco.errors import Portable
from aioduco.models.enums import TaskState


class Refusal(Portable):
    """The call is answered with a Thrift application error that carries this text."""


class SimulationFailed(Refusal, RuntimeError):
    """The simulation has failed, and stands still; for the methods of a simulator, too."""

    def __init__(self, failure: Exception) -> None:
        super().__init__(f"the simulation failed: {failure!r}")


class Rejected(Portable):
    """A task cannot be carried out: it ends at once, in a state that gives the reason."""

    def __init__(self, state: TaskState, message: str) -> None:
        super().__init__(message)
        self.state = state


def mismatch(message: str) -> Rejected:
    """Make the rejection of a task with a wrong parameter."""
    return Rejected(TaskState.PARAMETER_MISMATCH, message)


def illegal(message: str) -> Rejected:
    """Make the rejection of a task that the controller's state does not allow."""
    return Rejected(TaskState.ILLEGAL, message)


class Pending(Portable):
    """The task of a program's call has not ended; the cycle must not wait for it."""

    def __init__(self, id_: int) -> None:
        super().__init__(f"task {id_} has not ended")
        self.id = id_


_log = logging.getLogger(__name__)


class Forgiving:
    """Decides whether a call that deviates from the manual is accepted. Any thread may use it.

    Args:
        strict: whether to refuse all such calls.
    """

    def __init__(self, *, strict: bool = False) -> None:
        self.strict = strict
        self._lock = threading.Lock()
        self._counts: Counter[str] = Counter()

    @property
    def counts(self) -> dict[str, int]:
        """Number of accepted deviations of each kind, the most frequent first; empty for none."""
        with self._lock:
            return dict(self._counts.most_common())

    def forgive(self, kind: str, text: str) -> None:
        """Accept a deviation from the manual; the caller then uses the value that was meant.

        Args:
            kind: kind of the deviation, the same text for all calls of that kind.
            text: what is wrong with this call.

        Raises:
            Rejected: The simulator is strict; PARAMETER_MISMATCH.
        """
        if self.strict:
            raise mismatch(text)
        with self._lock:
            self._counts[kind] += 1
            first = self._counts[kind] == 1
        if first:
            _log.warning("forgiven, said once for %s: %s", kind, text)
