"""Hooks by which a forked child releases its parent's resources without disturbing the parent.

A fork copies the memory, but parent and child share the objects of the system. If the child shuts a
socket down, or removes a file from an epoll, this also affects the parent. Only closing a
descriptor does not. So each object that could do more than that registers itself here, and its
`forked` is called in the child before any other code runs there.
"""

from __future__ import annotations

import os
import weakref
from typing import Any, Final

#: the objects that a child of this process would inherit. Their `forked` releases the resources in
#: the child: the parent's threads do not run there, and a lock may be held by one of them.
fork_hooks: Final = weakref.WeakSet[Any]()


def _forked() -> None:
    inherited = list(fork_hooks)
    fork_hooks.clear()
    for one in inherited:
        try:
            one.forked()
        except Exception:
            # Continue with the other objects. The module is loaded here, since a stream's worker
            # does not need it.
            from aioduco._process.reporting import BackgroundLogger  # noqa: PLC0415

            BackgroundLogger(__name__).exception("a forked child could not let go of %r", one)


if hasattr(os, "register_at_fork"):  # only on systems with forks
    os.register_at_fork(after_in_child=_forked)
