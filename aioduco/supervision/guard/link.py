"""The program's end of its guard: one guard for all robots of a program.

Guarantees:
- Sending never waits: a guard that does not read is as good as none, and the caller goes on by
  the local way.
- Whoever waits for an answer is woken when the guard dies.
- The socket pair is not inherited by other processes that the program starts, not even by a
  fork, so that the guard sees the program's end when the program ends.
"""

from __future__ import annotations

import itertools
import logging
import os
import socket
import subprocess
import sys
import threading
import weakref
from typing import TYPE_CHECKING, Final

from aioduco._wire.prompt import send_at_once
from aioduco.errors import GuardLost
from aioduco.supervision.guard.messages import LARGEST, Beat, Done, pack, unpack

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.supervision.guard.messages import Message

_log = logging.getLogger(__name__)

#: seconds for a guard that has nothing left to do to end
_END_LIMIT: Final = 2.0


class Answer:
    """An answer that is waited for.

    Args:
        notify: called on the link's thread when the answer is there.
    """

    def __init__(self, notify: Callable[[], None]) -> None:
        self._notify = notify
        self.given: bool = False
        self.error: str = ""
        self.lost: bool = False

    def give(self, error: str, *, lost: bool = False) -> None:
        """Set what came of the request."""
        self.error, self.lost, self.given = error, lost, True
        self._notify()


class Watcher:
    """What a robot wants to hear of the guard; both are called on the link's thread."""

    def __init__(self, beat: Callable[[Beat], None], lost: Callable[[], None]) -> None:
        self.beat = beat
        self.lost = lost


class GuardLink:
    """A running guard.

    Raises:
        GuardLost: it cannot be started.
    """

    def __init__(self) -> None:
        self._tokens = itertools.count(1)
        self._robots = itertools.count(1)
        self._answers: dict[int, Answer] = {}
        self._watchers: dict[int, Watcher] = {}
        self.alive: bool = True
        self.users = 0
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "aioduco.supervision.guard", str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                # Not of the program's process group: what ends the program is not to end this.
                start_new_session=True,
            )
        except OSError as exc:
            ours.close()
            raise GuardLost(f"the guard's process could not be started: {exc}") from exc
        finally:
            theirs.close()
        self._socket = ours
        link = weakref.ref(self)
        os.register_at_fork(after_in_child=lambda: _forked(link()))
        self._thread = threading.Thread(target=self._read, name="aioduco-guard", daemon=True)
        self._thread.start()

    def __repr__(self) -> str:
        state = "alive" if self.alive else "gone"
        return f"<GuardLink to process {self._process.pid}, {state}, {self.users} robots>"

    def __del__(self) -> None:
        if (ours := getattr(self, "_socket", None)) is not None:
            ours.close()

    @property
    def pid(self) -> int:
        """The guard's process id."""
        return self._process.pid

    def enter(self, watcher: Watcher) -> int:
        """Have a robot's number, under which it hears of the guard."""
        robot = next(self._robots)
        self._watchers[robot] = watcher
        return robot

    def leave(self, robot: int) -> None:
        """Hear no more."""
        self._watchers.pop(robot, None)

    def tell(self, message: Message) -> bool:
        """Send a message. Returns whether the guard will read it, as far as can be known."""
        packet = pack(message)
        return self.alive and send_at_once(self._socket.fileno(), packet) == len(packet)

    def ask(self, request: Callable[[int], Message], answer: Answer) -> bool:
        """Send a request that is answered by `Done`.

        Args:
            request: makes the message, given the token.
            answer: is given what came of it; also when the guard dies.

        Returns:
            Whether it was sent; if not, the answer is never given.
        """
        token = next(self._tokens)
        self._answers[token] = answer
        if self.tell(request(token)):
            return True
        return self._answers.pop(token, None) is None

    def end(self) -> None:
        """Close the link: a guard without robots ends, one with robots stops their arms first."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            # the guard's end is gone
            return

    def join(self, timeout: float) -> bool:
        """Wait for the thread, which waits for the process. Returns whether both have ended."""
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def drop(self) -> None:
        """Let go of the link without a word: in a forked child, it is the parent's."""
        self.alive = False
        self._socket.close()

    def _read(self) -> None:
        try:
            while packet := self._socket.recv(LARGEST):
                match unpack(packet):
                    case Done(token, error):
                        answer = self._answers.pop(token, None)
                        if answer is not None:
                            answer.give(error)
                    case Beat() as beat:
                        watcher = self._watchers.get(beat.robot)
                        if watcher is not None:
                            watcher.beat(beat)
                    case other:
                        raise ValueError(f"a guard sent {other!r} to its program")
        except OSError:
            # A guard that was killed with unread packets resets the pair instead of closing it.
            _log.debug("the guard's socket was reset")
        finally:
            self._over()

    def _over(self) -> None:
        self.alive = False
        # Not closed: whoever is sending must not find another file under its number.
        self.end()
        for token in list(self._answers):
            answer = self._answers.pop(token, None)
            if answer is not None:
                answer.give("the guard's process is gone", lost=True)
        for watcher in list(self._watchers.values()):
            watcher.lost()
        try:
            self._process.wait(_END_LIMIT)
        except subprocess.TimeoutExpired:
            # It still stops arms that were left to it, or hangs. Either way it is not killed:
            # what stops an arm is not ended by force.
            _log.warning("the guard %d has not ended yet", self._process.pid)


def _forked(link: GuardLink | None) -> None:
    if link is not None:
        link.drop()


class _Shared:
    """The one guard of this program, for as long as a robot uses it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._link: GuardLink | None = None

    def acquire(self) -> GuardLink:
        with self._lock:
            if self._link is None or not self._link.alive:
                self._link = GuardLink()
            self._link.users += 1
            return self._link

    def release(self, link: GuardLink) -> None:
        with self._lock:
            link.users -= 1
            if link.users:
                return
            if self._link is link:
                self._link = None
        link.end()
        link.join(_END_LIMIT)


#: one per process, since the guard is there for the process as a whole: it sees its end
shared: Final = _Shared()
