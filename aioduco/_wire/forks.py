"""Hooks by which a forked child releases its parent's resources without disturbing the parent.

A fork copies the memory, but parent and child share the objects of the system. If the child shuts a
socket down, or removes a file from an epoll, this also affects the parent. Only closing a
descriptor does not. So each object that could do more than that registers itself here, and its
`forked` is called in the child before any other code runs there.
"""

from __future__ import annotations

import os
import weakref
from typing import Final, Protocol

__all__ = ["fork_hooks"]


class Inherited(Protocol):
    """An object that a fork copies, but whose resources still belong to the parent."""

    def forked(self) -> None:
        """Release the resources, in the child.

        The parent's threads do not run here, and a lock may be held by one of them.
        """
        ...


class _ForkHooks:
    """The objects that a child of this process would inherit; held by weak references."""

    def __init__(self) -> None:
        self._all: weakref.WeakSet[Inherited] = weakref.WeakSet()
        self._listens = False

    def add(self, one: Inherited) -> None:
        """Register an object: `one.forked` is called in every child that is forked from now on."""
        if not self._listens:
            self._listens = True
            if hasattr(os, "register_at_fork"):  # only on systems with forks
                os.register_at_fork(after_in_child=self._forked)
        self._all.add(one)

    def _forked(self) -> None:
        inherited, self._all = list(self._all), weakref.WeakSet()
        for one in inherited:
            try:
                one.forked()
            except Exception:
                # Continue with the other objects. The module is loaded here, since a stream's
                # worker does not need it.
                from aioduco._process.reporting import BackgroundLogger  # noqa: PLC0415

                BackgroundLogger(__name__).exception("a forked child could not let go of %r", one)


#: one per process, since a fork copies the process as a whole
fork_hooks: Final = _ForkHooks()
