"""What a forked child does with what is its parent's: it lets go of it, and disturbs nothing.

A fork copies what is in memory and shares what is in the system: a child that shuts a socket down,
or takes a file out of an epoll, does it to its parent. Only closing is the child's own affair. So
whatever could do more puts itself on the list here, and is told in the child, before anything else
runs there.
"""

from __future__ import annotations

import os
import weakref
from typing import Final, Protocol

__all__ = ["fork_hooks"]


class Inherited(Protocol):
    """What a fork copies, and what belongs to the parent all the same."""

    def forked(self) -> None:
        """Let go, in the child: no thread of the parent runs here, and its locks may be taken."""
        ...


class _ForkHooks:
    """All that a child of this process would inherit; it keeps none of it alive."""

    def __init__(self) -> None:
        self._all: weakref.WeakSet[Inherited] = weakref.WeakSet()
        self._listens = False

    def add(self, one: Inherited) -> None:
        """Have `one.forked` called in every child that is forked from now on."""
        if not self._listens:
            self._listens = True
            if hasattr(os, "register_at_fork"):  # where there are forks
                os.register_at_fork(after_in_child=self._forked)
        self._all.add(one)

    def _forked(self) -> None:
        inherited, self._all = list(self._all), weakref.WeakSet()
        for one in inherited:
            try:
                one.forked()
            except Exception:
                # The others are to be let go of all the same. Loaded here, since a stream's worker
                # needs none of it.
                from aioduco.reporting import BackgroundLogger  # noqa: PLC0415

                BackgroundLogger(__name__).exception("a forked child could not let go of %r", one)


#: one per process, since a fork copies the process as a whole
fork_hooks: Final = _ForkHooks()
