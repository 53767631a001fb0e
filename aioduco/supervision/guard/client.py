"""The program's end of its guard: one guard for all robots of a program.

Guarantees:
- Sending never waits: a guard that does not read counts as no guard.
- A caller that waits for an answer is woken when the guard dies.
- Other processes that the program starts do not inherit the socket pair, not even by a fork, so
  that the guard detects the program's exit at once.
"""

from __future__ import annotations

import itertools
import socket
import subprocess
import threading
from typing import TYPE_CHECKING, Final, TypeAlias

from aioduco._process.platform import missing_guard_features
from aioduco._process.reporting import BackgroundLogger
from aioduco._process.spawn import Process, Unstartable
from aioduco._wire.failures import resource_error
from aioduco._wire.forks import fork_hooks
from aioduco._wire.nonblocking import send_at_once
from aioduco.errors import GuardLost
from aioduco.supervision.guard.messages import MAX_PACKET, Beat, Done, LogMessage, pack, unpack

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.supervision.guard.messages import Message

_log = BackgroundLogger(__name__)

#: called on the link's thread with the answer to a request: its error, "" if it went well, and None
#: if the guard has died
Answered: TypeAlias = "Callable[[str | None], object]"

#: seconds for a guard without robots to exit
_END_LIMIT: Final = 2.0


class GuardLink:
    """A running guard.

    Raises:
        GuardLost: it cannot be started.
    """

    def __init__(self) -> None:
        self._tokens = itertools.count(1)
        self._robots = itertools.count(1)
        self._answers: dict[int, Answered] = {}
        #: for each robot, what is called with a beat, and when the guard is lost
        self._listeners: dict[int, tuple[Callable[[Beat], None], Callable[[], None]]] = {}
        self.alive: bool = True
        self.users = 0
        if missing := missing_guard_features():
            raise GuardLost(
                f"a guard's process needs Linux, and this system has no {missing}; nothing was "
                'moved. Connect without guard="process": the heartbeat then stops the arm of a '
                "program that dies or hangs"
            )
        try:
            ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        except OSError as exc:
            raise _not_started(exc) from exc
        try:
            # In a session of its own: a signal that ends the program's processes must not end it.
            process = Process("aioduco.supervision.guard.process", [theirs])
        except OSError as exc:
            ours.close()
            raise _not_started(exc) from exc
        except Unstartable as exc:
            ours.close()
            raise GuardLost(
                f"the guard's process was not started: {exc}, or connect without a guard"
            ) from exc
        finally:
            theirs.close()
        self._process = process
        self._popen = process.popen
        self._socket = ours
        fork_hooks.add(self)
        self._thread = threading.Thread(target=self._read, name="aioduco-guard", daemon=True)
        try:
            self._thread.start()
        except RuntimeError as exc:
            # Without a robot, the guard exits as soon as its socket closes.
            self.alive = False
            ours.close()
            self._popen.wait()
            process.close()
            raise _not_started(exc) from exc

    def __repr__(self) -> str:
        state = "alive" if self.alive else "gone"
        return f"<GuardLink to process {self.pid}, {state}, {self.users} robots>"

    def __del__(self) -> None:
        if (ours := getattr(self, "_socket", None)) is not None:
            ours.close()

    @property
    def pid(self) -> int:
        """The guard's process id."""
        return self._popen.pid

    @property
    def last_stderr_line(self) -> str:
        """The last line of the guard's standard error, once it has exited."""
        return self._process.stderr_tail.rpartition("\n")[2]

    def register(self, beaten: Callable[[Beat], None], lost: Callable[[], None]) -> int:
        """Register a robot's callbacks, for the link's thread. Returns the robot's number."""
        robot = next(self._robots)
        self._listeners[robot] = beaten, lost
        return robot

    def unregister(self, robot: int) -> None:
        """Unregister a robot."""
        self._listeners.pop(robot, None)

    def tell(self, message: Message) -> bool:
        """Send a message. Returns whether the guard will read it, as far as can be known."""
        packet = pack(message)
        return self.alive and send_at_once(self._socket.fileno(), packet) == len(packet)

    def ask(self, request: Callable[[int], Message], answered: Answered) -> bool:
        """Send a request that is answered by `Done`.

        Args:
            request: makes the message, given the token.
            answered: gets the answer.

        Returns:
            Whether it was sent; if not, `answered` is never called.
        """
        token = next(self._tokens)
        self._answers[token] = answered
        return self.tell(request(token)) or self._answers.pop(token, None) is None

    def end(self) -> None:
        """Close the link: a guard without robots exits, one with robots stops their arms first."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            # the guard has closed its end
            return

    def forked(self) -> None:
        """Close this copy of the socket in a forked child: the link belongs to the parent."""
        self.alive = False
        self._socket.close()

    def _read(self) -> None:
        try:
            while packet := self._socket.recv(MAX_PACKET):
                match unpack(packet):
                    case Done(token, error):
                        if (answered := self._answers.pop(token, None)) is not None:
                            answered(error)
                    case Beat() as beat:
                        if (listener := self._listeners.get(beat.robot)) is not None:
                            listener[0](beat)
                    case LogMessage(level, text):
                        _log.log(level, "the guard says: %s", text)
                    case other:
                        raise ValueError(f"a guard sent {other!r} to its program")
        except OSError:
            # If a guard is killed with unread packets, the socket pair is reset instead of closed.
            _log.debug("the guard's socket was reset")
        finally:
            self._over()

    def _over(self) -> None:
        self.alive = False
        # Not closed: a thread that is sending must not find another file under its number.
        self.end()
        for token in list(self._answers):
            if (answered := self._answers.pop(token, None)) is not None:
                answered(None)
        for _, lost in list(self._listeners.values()):
            lost()
        try:
            self._popen.wait(_END_LIMIT)
        except subprocess.TimeoutExpired:
            # It still stops arms that were left to it, or hangs. It is not killed in either case: a
            # process that may be stopping an arm must not be killed.
            _log.warning("the guard %d has not ended yet", self.pid)
        finally:
            self._process.close()


def _not_started(error: Exception) -> GuardLost:
    why = resource_error(error) or error
    return GuardLost(f"the guard's process could not be started: {why}. Nothing was moved")


class _Shared:
    """The one guard of this program, for as long as a robot uses it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._link: GuardLink | None = None
        fork_hooks.add(self)

    def forked(self) -> None:
        """Start anew in a forked child: it has no guard yet, and no thread that frees the lock."""
        self._lock = threading.Lock()
        self._link = None

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
        link._thread.join(_END_LIMIT)  # which waits for the process


#: one per process, because the guard serves the whole process, and detects its exit
shared: Final = _Shared()
