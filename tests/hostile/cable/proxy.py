"""Something between program and controller that keeps bytes and delivers them later.

    python -m hostile.cable.proxy HOST PORT

It listens on HOST, on a port that it says, and passes all bytes on to the controller on PORT of the
loopback. On "KIND SECONDS", read from its standard input, it says "begun" and keeps bytes by one of
`RULES`. On "pending" it says "pending" and when the last byte that it keeps is due, or nothing. It
says "delivered" whenever it has delivered all that it kept of a connection.

What the program sent is delivered even if the program has closed or reset its connection meanwhile,
as it is by a switch or a controller that has it in a buffer.
"""

from __future__ import annotations

import os
import selectors
import socket
import sys
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from .lines import say

#: s by which a motion's bytes come after those of the other connections that were held
GAP = 0.5

#: functions of the wire that make the arm move, as a request names them
_MOTIONS = (b"movej2", b"servoj")
#: the one of them that is called again and again
_STREAMED = b"servoj"

_CHUNK = 65536


@dataclass(frozen=True, slots=True)
class Outage:
    """A time in which bytes are kept."""

    begin: float
    seconds: float

    @property
    def end(self) -> float:
        """When it ends [s]."""
        return self.begin + self.seconds


def held(outage: Outage, now: float, motion: bool, request: bool) -> float:
    """Nothing passes until the end; then the motion comes last, after every stop."""
    return outage.end + (GAP if motion else 0.0)


def delayed(outage: Outage, now: float, motion: bool, request: bool) -> float:
    """Each byte takes as long as the outage."""
    return now + outage.seconds


def late(outage: Outage, now: float, motion: bool, request: bool) -> float:
    """The controller reads the motion's connection late, and all others at once."""
    return now + outage.seconds if motion and request else now


#: when bytes are due that come at `now` within an outage
RULES: dict[str, Callable[[Outage, float, bool, bool], float]] = {
    "held": held,
    "delayed": delayed,
    "late": late,
}


class Pipe:
    """One direction of a connection."""

    def __init__(self, source: socket.socket, sink: socket.socket, request: bool) -> None:
        self.source, self.sink, self.request = source, sink, request
        self.partner: Pipe
        #: whether a motion was sent since the outage began
        self.motion = False
        self.streams = False
        #: what is kept, with its time; empty bytes are the end
        self.kept: deque[tuple[float, bytes]] = deque()
        self.ended = False
        self.over = False
        self._last_due = 0.0
        self._delayed = 0

    def read(self, now: float, due: Callable[[Pipe, float], float]) -> None:
        """Take what the source has sent."""
        try:
            data = self.source.recv(_CHUNK)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self.ended = True
        if self.request and _STREAMED in data:
            self.streams = self.partner.streams = True
        if self.request and any(name in data for name in _MOTIONS):
            self.motion = self.partner.motion = True
        # in order
        self._last_due = max(due(self, now), self._last_due)
        if self._last_due > now:
            self._delayed += len(data)
        self.kept.append((self._last_due, data))

    def write(self, now: float) -> None:
        """Pass on what is due."""
        while self.kept and self.kept[0][0] <= now and not self.over:
            when, data = self.kept.popleft()
            if not data:
                self._end()
                break
            try:
                taken = self.sink.send(data)
            except BlockingIOError:
                taken = 0
            except OSError:
                self._end()
                break
            if taken < len(data):
                # tried again soon: the other side is slow to read
                self.kept.appendleft((when, data[taken:]))
                return
        # the end of a connection moves nothing
        if self._delayed and not any(data for _, data in self.kept):
            kind = ("motion" if self.motion else "other") + ("" if self.request else " answer")
            say("delivered", f"{self._delayed} bytes, {kind}", now)
            self._delayed = 0

    def _end(self) -> None:
        self.over = True
        self.kept.clear()
        with suppress(OSError):
            self.sink.shutdown(socket.SHUT_WR)


class Proxy:
    """Passes bytes on, in one thread."""

    def __init__(self, host: str, port: int) -> None:
        self._upstream = ("127.0.0.1", port)
        self._listener = socket.create_server((host, 0), backlog=64)
        self._listener.setblocking(False)
        self._selector = selectors.DefaultSelector()
        self._pipes: list[Pipe] = []
        self._rule: Callable[[Outage, float, bool, bool], float] | None = None
        self._outage = Outage(0.0, 0.0)

    def run(self) -> None:
        """Pass bytes on until the standard input is closed."""
        stdin = sys.stdin.fileno()
        self._selector.register(stdin, selectors.EVENT_READ, None)
        self._selector.register(self._listener, selectors.EVENT_READ, None)
        say("port", str(self._listener.getsockname()[1]))
        while True:
            ready = self._selector.select(self._patience())
            now = time.monotonic()
            for key, _ in ready:
                if isinstance(key.data, Pipe):
                    key.data.read(now, self._due)
                    if key.data.ended:
                        self._selector.unregister(key.data.source)
                elif key.fileobj is self._listener:
                    self._accept()
                elif commands := os.read(stdin, _CHUNK).decode():
                    for command in commands.splitlines():
                        self._obey(command)
                else:
                    return
            self._pass(time.monotonic())

    def _patience(self) -> float | None:
        dues = [pipe.kept[0][0] for pipe in self._pipes if pipe.kept]
        if not dues:
            return None
        # not 0: what is due and was not taken waits for a slow reader
        return max(0.001, min(dues) - time.monotonic())

    def _pass(self, now: float) -> None:
        # The motions last: a stop that is due at the same time comes first.
        for pipe in sorted(self._pipes, key=lambda pipe: pipe.motion):
            pipe.write(now)
        gone = [pipe for pipe in self._pipes if pipe.over and pipe.partner.over and pipe.request]
        for pipe in gone:
            for one in (pipe, pipe.partner):
                self._pipes.remove(one)
                if not one.ended:
                    self._selector.unregister(one.source)
            pipe.source.close()
            pipe.sink.close()

    def _due(self, pipe: Pipe, now: float) -> float:
        if self._rule is None or now >= self._outage.end:
            return now
        if pipe.streams and not pipe.motion:
            # A stream waits for each answer. What is kept of it is a set-point, not an answer.
            return now
        return self._rule(self._outage, now, pipe.motion, pipe.request)

    def _accept(self) -> None:
        client, _ = self._listener.accept()
        try:
            server = socket.create_connection(self._upstream)
        except OSError:
            client.close()
            return
        for each in (client, server):
            each.setblocking(False)
            each.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        there, back = Pipe(client, server, True), Pipe(server, client, False)
        there.partner, back.partner = back, there
        for pipe in (there, back):
            self._pipes.append(pipe)
            self._selector.register(pipe.source, selectors.EVENT_READ, pipe)

    def _obey(self, command: str) -> None:
        kind, *words = command.split()
        if kind in RULES:
            self._rule = RULES[kind]
            self._outage = Outage(time.monotonic(), float(words[0]))
            for pipe in self._pipes:
                pipe.motion = False
            say("begun", kind)
        else:
            dues = [pipe.kept[-1][0] for pipe in self._pipes if pipe.kept and pipe.request]
            say("pending", f"{max(dues):.3f}" if dues else "")


if __name__ == "__main__":
    Proxy(sys.argv[1], int(sys.argv[2])).run()
