"""What a controller takes although the manual forbids it, as public programs show.

A strict simulator refuses such calls, to find sloppy ones. A lenient one takes them, says so once
for each kind, and counts them.
"""

from __future__ import annotations

import logging
import threading
from collections import Counter

from aioduco.models.enums import TaskState
from aioduco.sim.refusal import Rejected

__all__ = ["Forgiving"]

_log = logging.getLogger(__name__)


class Forgiving:
    """Decides whether a call that is off the manual is taken. Any thread may ask.

    Args:
        strict: whether to refuse all of them.
    """

    def __init__(self, *, strict: bool = False) -> None:
        self.strict = strict
        self._lock = threading.Lock()
        self._counts: Counter[str] = Counter()

    @property
    def counts(self) -> dict[str, int]:
        """How often each kind was forgiven, most often first; empty if nothing was."""
        with self._lock:
            return dict(self._counts.most_common())

    def forgive(self, kind: str, text: str) -> None:
        """Take what is off the manual; the caller goes on with the value that it stands for.

        Args:
            kind: what is forgiven, the same text for all calls of that kind.
            text: what is wrong with this call.

        Raises:
            Rejected: The simulator is strict; PARAMETER_MISMATCH.
        """
        if self.strict:
            raise Rejected(TaskState.PARAMETER_MISMATCH, text)
        with self._lock:
            self._counts[kind] += 1
            first = self._counts[kind] == 1
        if first:
            _log.warning("forgiven, said once for %s: %s", kind, text)
